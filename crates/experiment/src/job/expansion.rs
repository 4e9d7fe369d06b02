//! The jobs that an experiment expands to.

use b2b_building::BuildingType;
use b2b_dataset::BuildingId;
use toml::{Table, Value};

use super::action::{AGENT, Action, Episodes, Job, Measurement, texts, train};
use super::entry;
use crate::definition::{Agent, Benchmark, Budget, Buildings, Experiment, RANDOM, REACTIVE, Training};

/// The buildings that an agent is trained on.
struct Subject {
    /// Name in the key of the job.
    name: String,
    /// The options that select it.
    options: Table,
    /// Test buildings of the agent.
    tests: Vec<String>,
}

impl Experiment {
    /// Returns the jobs of a budget, always in the same order.
    pub fn jobs(&self, budget: &Budget) -> Vec<Job> {
        if let Some(benchmark) = self.measure {
            return vec![self.measurement(benchmark)];
        }
        let experiment = self.with_tasks_of(budget);
        let mut jobs = experiment.controller_jobs(budget);
        for agent in experiment.agents_of(budget) {
            let own = agent.budget(budget);
            match agent.trains {
                Training::Problem => {
                    jobs.extend(agent.problems.iter().map(|problem| entry::job(agent, problem, &own)));
                }
                _ => jobs.extend(experiment.trainings(agent, &own)),
            }
        }
        jobs
    }

    fn measurement(&self, benchmark: Benchmark) -> Job {
        let types = self.types.iter().map(ToString::to_string).collect();
        Job { key: "measure/all".into(), actions: vec![Action::Measure(Measurement { benchmark, types })] }
    }

    /// Returns the jobs of the controllers and, on problems, of the reactive controllers and random actions.
    fn controller_jobs(&self, budget: &Budget) -> Vec<Job> {
        let mut jobs = Vec::new();
        for controller in self.kept_controllers() {
            let of_type = |each: &BuildingType| self.controller_job(controller, *each, &budget.buildings);
            jobs.extend(self.types.iter().map(of_type));
        }
        for policy in [REACTIVE, RANDOM].into_iter().filter(|_| self.reactive) {
            jobs.extend(self.problems.iter().map(|problem| entry::built_in(policy, problem, budget)));
        }
        jobs
    }

    fn controller_job(&self, controller: &str, building_type: BuildingType, buildings: &Buildings) -> Job {
        let episodes = Episodes {
            buildings: texts(&self.tests(building_type, buildings)),
            tasks: self.tasks.clone(),
            periods: self.periods.clone(),
        };
        Job { key: format!("{controller}/{building_type}"), actions: vec![Action::Evaluate(episodes)] }
    }

    fn trainings(&self, agent: &Agent, budget: &Budget) -> Vec<Job> {
        let task_sets = parts(&self.tasks, agent.all_tasks, "all-tasks");
        let period_sets = parts(&self.periods, agent.all_periods, "all-periods");
        let mut jobs = Vec::new();
        for subject in self.subjects(agent.trains, &budget.buildings) {
            for (period, periods) in &period_sets {
                for (task, tasks) in &task_sets {
                    let key = format!("{}/{}_{task}_{period}", agent.name, subject.name);
                    let episodes = Episodes {
                        buildings: subject.tests.clone(),
                        tasks: tasks.to_vec(),
                        periods: periods.to_vec(),
                    };
                    let config = config(agent, budget, &subject, &episodes);
                    jobs.extend((0..budget.seeds).map(|seed| Job {
                        key: format!("{key}_{seed}"),
                        actions: actions(budget, config.clone(), seed, &episodes),
                    }));
                }
            }
        }
        jobs
    }

    /// Returns the training subjects of an agent, with the test buildings of a budget.
    fn subjects(&self, trains: Training, buildings: &Buildings) -> Vec<Subject> {
        let subject = |name: String, option: &str, value: Value, tests: &[BuildingId]| Subject {
            name,
            options: Table::from_iter([(option.to_owned(), value)]),
            tests: texts(tests),
        };
        let text = |each: &dyn std::fmt::Display| Value::String(each.to_string());
        let tests = |each: &BuildingType| self.tests(*each, buildings);
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

/// Returns what each training covers, with a label: every value by itself, or all together.
fn parts<'a>(values: &'a [String], together: bool, label: &'a str) -> Vec<(&'a str, &'a [String])> {
    match together {
        true => vec![(label, values)],
        false => values.iter().map(|value| (&value[..], std::slice::from_ref(value))).collect(),
    }
}

/// Returns the options of a training run for some episodes.
fn config(agent: &Agent, budget: &Budget, subject: &Subject, episodes: &Episodes) -> Table {
    let mut config = agent.options.clone();
    if budget.with_best {
        config.insert("keep".to_owned(), Value::String("best".into()));
    }
    config.extend(subject.options.clone());
    config.insert("task".to_owned(), Value::String(episodes.tasks.join(",")));
    config.insert("period".to_owned(), Value::String(episodes.periods.join(",")));
    config
}

/// Returns a training run and the evaluation of its agent, or of both of its agents.
fn actions(budget: &Budget, config: Table, seed: u64, episodes: &Episodes) -> Vec<Action> {
    let mut actions = vec![train(AGENT, config, budget.steps, seed), Action::Evaluate(episodes.clone())];
    if budget.with_best {
        actions.push(Action::EvaluateLast(episodes.clone()));
    }
    actions
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_learn::train::TrainConfig;

    fn jobs_of(experiment: &Experiment, budget: &str) -> Vec<Job> {
        experiment.jobs(experiment.budget(budget).unwrap())
    }

    fn jobs(experiment: &str, budget: &str) -> Vec<Job> {
        jobs_of(&Experiment::named(experiment).unwrap(), budget)
    }

    #[test]
    fn the_full_table_of_the_paper_has_384_runs_an_agent() {
        let jobs = jobs("ppo", "full");
        let of_paper: Vec<&Job> = jobs.iter().filter(|job| job.agent() == "paper").collect();
        assert_eq!((of_paper.len(), jobs.len()), (384, 768));
        assert_eq!(of_paper.iter().map(|job| job.steps()).sum::<u64>(), 384 * 5_000_000);
    }

    #[test]
    fn a_budget_may_have_tasks_of_its_own() {
        let jobs = jobs("supervision", "tou");
        assert!(jobs.iter().all(|job| job.episodes().unwrap().tasks == ["operate+tou"]));
        assert!(jobs.iter().any(|job| job.key == "graph/all-types_operate+tou_all-periods_0"), "{jobs:?}");
    }

    #[test]
    fn every_training_of_every_shipped_experiment_has_a_valid_configuration_and_a_key_of_its_own() {
        for experiment in Experiment::all() {
            for budget in experiment.budgets() {
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
        let jobs = jobs("weights", "quick");
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
        let jobs = |budget| jobs_of(&experiment, budget);
        let of = |jobs: Vec<Job>, key: &str| jobs.into_iter().find(|job| job.key == key).unwrap();
        let full = of(jobs("full"), "residual/dynamics-house");
        let Some(Action::Enter(entry)) = full.actions.last() else { unreachable!() };
        assert_eq!((full.actions.len(), &entry.policy[..]), (10, "agent-{seed}"));
        assert!(entry.test.is_empty() && entry.seeds.is_empty() && entry.episodes.buildings.len() == 100);
        let quick = of(jobs("quick"), "graph/retail-to-warehouse");
        let Some(Action::Enter(entry)) = quick.actions.last() else { unreachable!() };
        assert_eq!(
            (&entry.seeds[..], entry.test.len()),
            (&[0][..], experiment.budget("quick").unwrap().buildings.of_all().unwrap())
        );
        let reactive = of(jobs("quick"), "reactive/four-types");
        assert!(matches!(&reactive.actions[..], [Action::Enter(entry)] if entry.policy == REACTIVE));
    }

    #[test]
    fn controllers_are_evaluated_on_the_test_buildings_of_each_type_without_a_training() {
        let (quick, full) = (jobs("operation", "quick"), jobs("operation", "full"));
        assert_eq!((quick.len(), full.len()), (18, 18), "three controllers, six types");
        let count = |jobs: &[Job]| jobs.iter().map(Job::episode_count).sum::<usize>();
        assert_eq!((count(&quick), count(&full)), (180, 720), "five periods");
        let job = quick.iter().find(|job| job.key == "own/OfficeSmall").unwrap();
        assert_eq!((job.policy(), job.steps(), job.actions.len()), ("own", 0, 1));
        let trained = &jobs("ppo", "quick")[0];
        assert_eq!(trained.policy(), AGENT);
    }

    #[test]
    fn one_training_covers_all_periods_and_a_budget_may_be_without_agents() {
        let jobs_of = |budget: &str| jobs("supervision", budget);
        let full = jobs_of("full");
        let of = |agent: &str| full.iter().filter(|job| job.agent() == agent).collect::<Vec<_>>();
        let [graph, ..] = of("graph")[..] else { unreachable!() };
        assert_eq!(graph.key, "graph/all-types_operate_all-periods_0");
        assert_eq!((graph.episode_count(), graph.episodes().unwrap().periods.len()), (240, 5));
        let Action::Train { config, .. } = &graph.actions[0] else { unreachable!() };
        assert_eq!(
            config["period"].as_str(),
            Some("peak-heating,typical-heating,peak-cooling,typical-cooling,mixed")
        );
        assert_eq!((of("graph").len(), of("flat").len(), of("specialist").len()), (3, 18, 48));
        assert!(jobs_of("controllers").iter().all(|job| job.trainings() == 0));
    }

    #[test]
    fn a_generalist_is_evaluated_on_test_buildings_and_a_specialist_on_its_own() {
        let jobs = jobs("dynamics", "quick");
        let of = |agent: &str| jobs.iter().filter(|job| job.agent() == agent).collect::<Vec<_>>();
        let (specialists, generalists) = (of("specialist"), of("generalist"));
        assert_eq!((specialists.len(), generalists.len()), (10, 3));
        assert!(specialists.iter().all(|job| job.episodes().unwrap().buildings.len() == 1));
        assert!(generalists.iter().all(|job| job.episodes().unwrap().buildings.len() == 20));
    }

    #[test]
    fn the_part_of_the_paper_trains_what_the_paper_trains_and_evaluates_the_last_agent_and_the_best() {
        let jobs = jobs("ppo", "paper-part");
        let houses = jobs.iter().filter(|job| job.key.starts_with("paper/SingleFamilyHouse")).count();
        assert_eq!((jobs.len(), houses), (144, 64));
        let job =
            jobs.iter().find(|job| job.key == "paper/SingleFamilyHouse-0018_constant_winter_0").unwrap();
        let [Action::Train { config, steps, .. }, Action::Evaluate(kept), Action::EvaluateLast(last)] =
            &job.actions[..]
        else {
            panic!("{:?}", job.actions)
        };
        assert_eq!((*steps, kept), (5_000_000, last));
        let text = "preset = \"paper\"\nkeep = \"best\"\nbuildings = [\"SingleFamilyHouse-0018\"]\ntask = \"constant\"\n\
                    period = \"winter\"\nsteps = 5000000\nseed = 0\n\n[evaluation]\nwhole_period = false\n";
        assert_eq!(toml::to_string(config).unwrap(), text);
        // An experiment whose options keep the best, in a budget without `with_best`, wrote this.
        let evaluated_once = "871ceea4a66688a2b13a96c374371a109188a4269750d73077b8ee31d09d6945";
        assert_eq!(job.actions_of(evaluated_once), Some(2));
    }

    #[test]
    fn ppo_has_the_runs_of_rewards_and_some_of_direct() {
        let ppo = jobs("ppo", "paper-part");
        let shared = |name, budget| {
            let jobs = jobs(name, budget);
            let shared = jobs.iter().filter(|job| ppo.contains(job)).count();
            (shared, jobs.len())
        };
        // Beside them, the reactive controllers of each of six types.
        let winters_without_energy = ppo.iter().filter(|job| {
            let episodes = job.episodes().unwrap();
            episodes.periods == ["winter"] && !episodes.tasks[0].contains('+')
        });
        let count = winters_without_energy.count();
        assert_eq!(shared("rewards", "paper-part"), (count, count + 6));
        // Two houses and two small offices, one of three seeds.
        assert_eq!(shared("direct", "full").0, 4);
    }
}
