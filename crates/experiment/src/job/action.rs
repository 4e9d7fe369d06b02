//! A job of an experiment: actions in a folder.

use b2b_base::digest::sha256;
use b2b_dataset::BuildingId;
use serde::{Deserialize, Serialize, Serializer};
use toml::{Table, Value};

use crate::definition::Benchmark;

/// Name of the folder of the agent that a job's training run keeps.
pub const AGENT: &str = "agent";
/// Name of the folder of the last agent of a job's training.
pub const LAST_AGENT: &str = "agent/last";

/// An independent part of an experiment: actions in a folder, one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Name of its folder: `AGENT/SUBJECT_TASK_PERIOD_SEED`, `AGENT/PROBLEM`, `CONTROLLER/TYPE` or `measure/all`.
    pub key: String,
    /// Its actions, in order.
    pub actions: Vec<Action>,
}

/// One part of a job, carried out by a process of its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Action {
    /// Trains an agent.
    Train {
        /// Name of its folder.
        agent: String,
        /// The whole configuration, as a file for `b2b train --config`.
        config: Table,
        /// Environment steps.
        steps: u64,
    },
    /// Evaluates the agent of the job, or the controller of a job without a training.
    Evaluate(Episodes),
    /// Evaluates the last agent of the job's training run, in addition to the one it keeps.
    EvaluateLast(Episodes),
    /// Enters the agents of the job, or a built-in policy, on a benchmark problem.
    Enter(Entry),
    /// Runs a benchmark whose JSON is the result.
    Measure(#[serde(serialize_with = "as_words")] Measurement),
}

/// Serializes the words of the command, whose hash identifies the results.
fn as_words<S: Serializer>(measurement: &Measurement, serializer: S) -> Result<S::Ok, S::Error> {
    measurement.words().serialize(serializer)
}

/// A benchmark run for buildings of some types.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// The benchmark.
    pub benchmark: Benchmark,
    /// Building types.
    pub types: Vec<String>,
}

impl Measurement {
    /// Returns the words of the command that measures the same.
    pub(crate) fn words(&self) -> Vec<String> {
        let Benchmark::Speed = self.benchmark;
        let types = self.types.iter().flat_map(|each| ["--type", each]);
        ["bench", "speed"].into_iter().chain(types).map(str::to_owned).collect()
    }
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

/// An entry on a benchmark problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Name of the problem.
    pub problem: String,
    /// Policy, with `{seed}` in place of a seed.
    pub policy: String,
    /// Training steps of an agent.
    pub steps: Option<u64>,
    /// Seeds, if not all of the problem's.
    pub seeds: Vec<u64>,
    /// Test buildings, if not all of the problem's.
    pub test: Vec<String>,
    /// The test episodes of one seed.
    pub episodes: Episodes,
}

impl Episodes {
    fn count(&self) -> usize {
        self.buildings.len() * self.tasks.len() * self.periods.len()
    }
}

impl Job {
    /// Returns the number of training steps in the job.
    pub fn steps(&self) -> u64 {
        let steps = |action: &Action| match action {
            Action::Train { steps, .. } => *steps,
            _ => 0,
        };
        self.actions.iter().map(steps).sum()
    }

    /// Returns the number of agents that the job trains: none, one, or on a benchmark problem one for each seed.
    pub fn trainings(&self) -> usize {
        self.actions.iter().filter(|action| matches!(action, Action::Train { .. })).count()
    }

    /// Returns the episodes that the job evaluates, of one seed.
    pub fn episodes(&self) -> Option<&Episodes> {
        self.actions.iter().find_map(|action| match action {
            Action::Evaluate(episodes) | Action::Enter(Entry { episodes, .. }) => Some(episodes),
            _ => None,
        })
    }

    /// Returns the number of evaluated episodes of one seed, all policies together.
    pub fn episode_count(&self) -> usize {
        let count = |action: &Action| match action {
            Action::Evaluate(episodes)
            | Action::EvaluateLast(episodes)
            | Action::Enter(Entry { episodes, .. }) => episodes.count(),
            _ => 0,
        };
        self.actions.iter().map(count).sum()
    }

    /// Returns whether the job evaluates the last agent of its training run in addition to the one it keeps.
    pub fn has_last(&self) -> bool {
        self.actions.iter().any(|action| matches!(action, Action::EvaluateLast(_)))
    }

    /// Returns the SHA-256 of the actions, by which results of other actions are told apart from this job's.
    pub fn actions_sha256(&self) -> String {
        self.first_actions_sha256(self.actions.len())
    }

    fn first_actions_sha256(&self, count: usize) -> String {
        sha256(serde_json::to_vec(&self.actions[..count]).expect("plain data always serializes"))
    }

    /// Returns how many of the job's actions, from the first on, a hash covers, so that a job that has grown keeps its
    /// earlier results. An empty hash, from older results, covers all; `None` if the hash is of other actions.
    pub fn actions_of(&self, actions_sha256: &str) -> Option<usize> {
        let all = self.actions.len();
        match actions_sha256 {
            "" => Some(all),
            hash => (1..=all).rev().find(|count| self.first_actions_sha256(*count) == hash),
        }
    }

    /// Returns the building types of the episodes that the job evaluates.
    pub fn building_types(&self) -> impl Iterator<Item = &str> {
        let buildings = self.episodes().map_or(&[][..], |episodes| &episodes.buildings[..]);
        buildings.iter().map(|building| building.split_once('-').map_or(&building[..], |(name, _)| name))
    }

    /// Returns what the job evaluates: its agent, or the controller of a job without a training.
    pub fn policy(&self) -> &str {
        if self.trainings() > 0 { AGENT } else { self.agent() }
    }

    /// Returns the first part of the key: the name of the agent or controller.
    pub fn agent(&self) -> &str {
        self.key.split_once('/').map_or(&self.key, |(agent, _)| agent)
    }
}

/// Returns the training run of an agent.
pub(super) fn train(agent: &str, mut config: Table, steps: u64, seed: u64) -> Action {
    config.insert("steps".to_owned(), Value::Integer(steps as i64));
    config.insert("seed".to_owned(), Value::Integer(seed as i64));
    // The job evaluates the agent itself.
    let evaluation = config.entry("evaluation").or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(evaluation) = evaluation {
        evaluation.insert("whole_period".to_owned(), Value::Boolean(false));
    }
    Action::Train { agent: agent.to_owned(), config, steps }
}

pub(super) fn texts(ids: &[BuildingId]) -> Vec<String> {
    ids.iter().map(ToString::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grown_job_still_matches_the_hash_of_its_first_actions() {
        let episodes = Episodes { buildings: vec![], tasks: vec![], periods: vec![] };
        let training = train(AGENT, Table::new(), 10, 0);
        let first = vec![training, Action::Evaluate(episodes.clone())];
        let before = Job { key: "a/b".into(), actions: first.clone() };
        let grown = Job { actions: [first, vec![Action::EvaluateLast(episodes)]].concat(), ..before.clone() };
        assert_eq!(grown.actions_of(&before.actions_sha256()), Some(2));
        assert_eq!(grown.actions_of(&grown.actions_sha256()), Some(3));
        assert_eq!((grown.actions_of(""), grown.actions_of("0123")), (Some(3), None));
        assert_eq!(before.actions_of(&grown.actions_sha256()), None);
    }
}
