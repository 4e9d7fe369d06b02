//! The jobs that an experiment expands to.

use b2b_building::BuildingType;
use b2b_dataset::BuildingId;
use toml::{Table, Value};

use crate::definition::{Agent, BudgetName, Experiment, RANDOM, REACTIVE, Training};
use crate::entry;
use crate::job::{AGENT, Action, Episodes, Job, texts, train};

/// What a training run is on.
struct Subject {
    /// Name in the key of the job.
    name: String,
    /// The options that select it.
    options: Table,
    /// Test buildings of the agent.
    tests: Vec<String>,
}

impl Experiment {
    /// Returns the jobs under a budget, always in the same order.
    pub fn jobs(&self, budget: BudgetName) -> Vec<Job> {
        if !self.measure.is_empty() {
            let mut arguments = self.measure.clone();
            arguments.extend(self.types.iter().flat_map(|each| ["--type".to_owned(), each.to_string()]));
            return vec![Job { key: "measure/all".into(), actions: vec![Action::Measure(arguments)] }];
        }
        let mut jobs = Vec::new();
        if self.reactive {
            let of_budget = self.budget(budget);
            jobs.extend(self.types.iter().map(|each| self.reactive_job(*each, of_budget.buildings)));
            for policy in [REACTIVE, RANDOM] {
                jobs.extend(self.problems.iter().map(|problem| entry::built_in(policy, problem, of_budget)));
            }
        }
        for agent in &self.agents {
            match agent.trains {
                Training::Problem => {
                    let job = |problem: &String| entry::job(agent, problem, agent.budget(self, budget));
                    jobs.extend(agent.problems.iter().map(job));
                }
                _ => jobs.extend(self.trainings(agent, budget)),
            }
        }
        jobs
    }

    fn reactive_job(&self, building_type: BuildingType, count: usize) -> Job {
        let episodes = Episodes {
            buildings: texts(&self.buildings(building_type, count)),
            tasks: self.tasks.clone(),
            periods: self.periods.clone(),
        };
        Job { key: format!("{REACTIVE}/{building_type}"), actions: vec![Action::Evaluate(episodes)] }
    }

    fn trainings(&self, agent: &Agent, name: BudgetName) -> Vec<Job> {
        let budget = agent.budget(self, name);
        let task_sets: Vec<(&str, &[String])> = match agent.all_tasks {
            true => vec![("all-tasks", &self.tasks)],
            false => self.tasks.iter().map(|task| (&task[..], std::slice::from_ref(task))).collect(),
        };
        let mut jobs = Vec::new();
        for subject in self.subjects(agent.trains, budget.buildings) {
            for period in &self.periods {
                for (label, tasks) in &task_sets {
                    let key = format!("{}/{}_{label}_{period}", agent.name, subject.name);
                    let mut config = agent.options.clone();
                    config.extend(subject.options.clone());
                    config.insert("task".to_owned(), Value::String(tasks.join(",")));
                    config.insert("period".to_owned(), Value::String(period.clone()));
                    let episodes = Episodes {
                        buildings: subject.tests.clone(),
                        tasks: tasks.to_vec(),
                        periods: vec![period.clone()],
                    };
                    jobs.extend((0..budget.seeds).map(|seed| Job {
                        key: format!("{key}_{seed}"),
                        actions: vec![
                            train(AGENT, config.clone(), budget.steps, seed),
                            Action::Evaluate(episodes.clone()),
                        ],
                    }));
                }
            }
        }
        jobs
    }

    /// Returns what an agent is trained on, with `count` test buildings of each type.
    fn subjects(&self, trains: Training, count: usize) -> Vec<Subject> {
        let subject = |name: String, option: &str, value: Value, tests: &[BuildingId]| Subject {
            name,
            options: Table::from_iter([(option.to_owned(), value)]),
            tests: texts(tests),
        };
        let text = |each: &dyn std::fmt::Display| Value::String(each.to_string());
        let tests = |building_type: &BuildingType| self.buildings(*building_type, count);
        match trains {
            Training::Building => {
                let own = |id: BuildingId| {
                    subject(id.to_string(), "buildings", Value::Array(vec![text(&id)]), &[id])
                };
                self.types.iter().flat_map(tests).map(own).collect()
            }
            Training::Type => {
                let own = |each: &BuildingType| {
                    subject(each.to_string(), "building_type", text(each), &tests(each))
                };
                self.types.iter().map(own).collect()
            }
            Training::AllTypes => {
                let types = self.types.iter().map(|each| text(each)).collect();
                let all: Vec<BuildingId> = self.types.iter().flat_map(tests).collect();
                vec![subject("all-types".into(), "building_type", Value::Array(types), &all)]
            }
            Training::Problem => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_learn::train::TrainConfig;

    #[test]
    fn the_full_table_of_the_paper_has_384_runs_an_agent() {
        let jobs = Experiment::named("ppo").unwrap().jobs(BudgetName::Full);
        let of_paper: Vec<&Job> = jobs.iter().filter(|job| job.agent() == "paper").collect();
        assert_eq!((of_paper.len(), jobs.len()), (384, 768));
        assert_eq!(of_paper.iter().map(|job| job.steps()).sum::<u64>(), 384 * 5_000_000);
    }

    #[test]
    fn every_training_of_every_shipped_experiment_has_a_valid_configuration_and_a_key_of_its_own() {
        for experiment in Experiment::all() {
            for budget in [BudgetName::Quick, BudgetName::Full] {
                let jobs = experiment.jobs(budget);
                assert!(!jobs.is_empty() && jobs == experiment.jobs(budget));
                for (number, job) in jobs.iter().enumerate() {
                    assert!(jobs[..number].iter().all(|other| other.key != job.key), "{}", job.key);
                    if let [Action::Train { config, .. }, ..] = &job.actions[..] {
                        assert_eq!(config.contains_key("task"), experiment.problems.is_empty());
                        let config = TrainConfig::default().with_changes(&toml::to_string(config).unwrap());
                        config.unwrap().check().unwrap();
                    }
                }
            }
        }
    }

    #[test]
    fn an_agent_for_all_tasks_is_trained_once_for_a_building_and_evaluated_on_each_task() {
        let jobs = Experiment::named("weights").unwrap().jobs(BudgetName::Quick);
        let of = |agent: &str| jobs.iter().filter(|job| job.agent() == agent).collect::<Vec<_>>();
        let (conditioned, residual) = (of("conditioned"), of("residual"));
        assert_eq!(residual.len(), 8 * conditioned.len());
        assert!(conditioned.iter().all(|job| job.episodes().unwrap().tasks.len() == 8));
        let Action::Train { config, .. } = &conditioned[0].actions[0] else { unreachable!() };
        assert_eq!(config["task"].as_str().unwrap().split(',').count(), 8);
    }

    #[test]
    fn an_agent_is_trained_for_every_seed_of_a_problem_and_entered_once() {
        let experiment = Experiment::named("board").unwrap();
        let jobs = |budget| experiment.jobs(budget);
        let of = |jobs: Vec<Job>, key: &str| jobs.into_iter().find(|job| job.key == key).unwrap();
        let full = of(jobs(BudgetName::Full), "residual/dynamics-house");
        let Some(Action::Enter(entry)) = full.actions.last() else { unreachable!() };
        assert_eq!((full.actions.len(), &entry.policy[..]), (10, "agent-{seed}"));
        assert!(entry.test.is_empty() && entry.seeds.is_empty() && entry.episodes.buildings.len() == 100);
        let quick = of(jobs(BudgetName::Quick), "graph/retail-to-warehouse");
        let Some(Action::Enter(entry)) = quick.actions.last() else { unreachable!() };
        assert_eq!((&entry.seeds[..], entry.test.len()), (&[0][..], experiment.quick.buildings));
        let reactive = of(jobs(BudgetName::Quick), "reactive/four-types");
        assert!(matches!(&reactive.actions[..], [Action::Enter(entry)] if entry.policy == REACTIVE));
    }

    #[test]
    fn a_generalist_is_evaluated_on_test_buildings_and_a_specialist_on_its_own() {
        let jobs = Experiment::named("dynamics").unwrap().jobs(BudgetName::Quick);
        let of = |agent: &str| jobs.iter().filter(|job| job.agent() == agent).collect::<Vec<_>>();
        let (specialists, generalists) = (of("specialist"), of("generalist"));
        assert_eq!((specialists.len(), generalists.len()), (10, 3));
        assert!(specialists.iter().all(|job| job.episodes().unwrap().buildings.len() == 1));
        assert!(generalists.iter().all(|job| job.episodes().unwrap().buildings.len() == 20));
    }
}
