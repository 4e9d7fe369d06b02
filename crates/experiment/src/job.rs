//! The jobs of an experiment.

use b2b_building::BuildingType;
use b2b_dataset::BuildingId;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::definition::{Agent, BudgetName, Experiment, REACTIVE, Training};

/// An independent part of an experiment: actions in a folder, one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Name of its folder, `AGENT/SUBJECT_TASK_PERIOD_SEED`.
    pub key: String,
    /// Its actions, in order.
    pub actions: Vec<Action>,
}

/// One `b2b` command.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Trains an agent.
    Train {
        /// The whole configuration, as a file for `b2b train --config`.
        config: Table,
        /// Environment steps.
        steps: u64,
    },
    /// Evaluates the agent of the job, or the reactive controllers in a job without a training.
    Evaluate(Episodes),
    /// Runs a command whose JSON is the result.
    Measure(Vec<String>),
}

/// Episodes: every building under every task in every period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episodes {
    /// Ids of the buildings.
    pub buildings: Vec<String>,
    /// Tasks.
    pub tasks: Vec<String>,
    /// Run periods.
    pub periods: Vec<String>,
}

impl Job {
    /// Returns the steps that the job trains.
    pub fn steps(&self) -> u64 {
        let steps = |action: &Action| match action {
            Action::Train { steps, .. } => *steps,
            _ => 0,
        };
        self.actions.iter().map(steps).sum()
    }

    /// Returns the episodes that the job evaluates.
    pub fn episodes(&self) -> Option<&Episodes> {
        self.actions.iter().find_map(|action| match action {
            Action::Evaluate(episodes) => Some(episodes),
            _ => None,
        })
    }

    /// Returns the first part of the key: the name of the agent.
    pub fn agent(&self) -> &str {
        self.key.split_once('/').map_or(&self.key, |(agent, _)| agent)
    }
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
            let count = self.budget(budget).buildings;
            jobs.extend(self.types.iter().map(|each| self.reactive_job(*each, count)));
        }
        for agent in &self.agents {
            jobs.extend(self.trainings(agent, budget));
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
        let tests = |building_type| self.buildings(building_type, budget.buildings);
        // Subject of the training, its options, and the buildings of the evaluation.
        let mut subjects: Vec<(String, Table, Vec<String>)> = Vec::new();
        match agent.trains {
            Training::Building => {
                for id in self.types.iter().flat_map(|each| tests(*each)) {
                    subjects.push((id.to_string(), buildings_option(&[id]), texts(&[id])));
                }
            }
            Training::Type => {
                for each in &self.types {
                    let option = option("building_type", Value::String(each.to_string()));
                    subjects.push((each.to_string(), option, texts(&tests(*each))));
                }
            }
            Training::AllTypes => {
                let types = self.types.iter().map(|each| Value::String(each.to_string())).collect();
                let all: Vec<BuildingId> = self.types.iter().flat_map(|each| tests(*each)).collect();
                subjects.push((
                    "all-types".into(),
                    option("building_type", Value::Array(types)),
                    texts(&all),
                ));
            }
        }
        let task_sets: Vec<(&str, &[String])> = match agent.all_tasks {
            true => vec![("all-tasks", &self.tasks)],
            false => self.tasks.iter().map(|task| (&task[..], std::slice::from_ref(task))).collect(),
        };
        let mut jobs = Vec::new();
        for (subject, selected, buildings) in &subjects {
            for period in &self.periods {
                for (label, tasks) in &task_sets {
                    for seed in 0..budget.seeds {
                        let mut config = agent.options.clone();
                        config.extend(selected.clone());
                        config.extend([
                            ("task".to_owned(), Value::String(tasks.join(","))),
                            ("period".to_owned(), Value::String(period.clone())),
                            ("steps".to_owned(), Value::Integer(budget.steps as i64)),
                            ("seed".to_owned(), Value::Integer(seed as i64)),
                        ]);
                        let episodes = Episodes {
                            buildings: buildings.clone(),
                            tasks: tasks.to_vec(),
                            periods: vec![period.clone()],
                        };
                        jobs.push(Job {
                            key: format!("{}/{subject}_{label}_{period}_{seed}", agent.name),
                            actions: vec![
                                Action::Train { config, steps: budget.steps },
                                Action::Evaluate(episodes),
                            ],
                        });
                    }
                }
            }
        }
        jobs
    }
}

fn texts(ids: &[BuildingId]) -> Vec<String> {
    ids.iter().map(ToString::to_string).collect()
}

fn buildings_option(ids: &[BuildingId]) -> Table {
    option("buildings", Value::Array(texts(ids).into_iter().map(Value::String).collect()))
}

fn option(name: &str, value: Value) -> Table {
    Table::from_iter([(name.to_owned(), value)])
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
    fn a_generalist_is_evaluated_on_test_buildings_and_a_specialist_on_its_own() {
        let jobs = Experiment::named("dynamics").unwrap().jobs(BudgetName::Quick);
        let of = |agent: &str| jobs.iter().filter(|job| job.agent() == agent).collect::<Vec<_>>();
        let (specialists, generalists) = (of("specialist"), of("generalist"));
        assert_eq!((specialists.len(), generalists.len()), (10, 3));
        assert!(specialists.iter().all(|job| job.episodes().unwrap().buildings.len() == 1));
        assert!(generalists.iter().all(|job| job.episodes().unwrap().buildings.len() == 20));
    }
}
