//! A job of an experiment: commands in a folder.

use b2b_base::digest::sha256;
use b2b_dataset::BuildingId;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// Name of the folder of a job's agent.
pub(crate) const AGENT: &str = "agent";

/// An independent part of an experiment: actions in a folder, one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Name of its folder, `AGENT/SUBJECT_TASK_PERIOD_SEED` or `AGENT/PROBLEM`.
    pub key: String,
    /// Its actions, in order.
    pub actions: Vec<Action>,
}

/// One `b2b` command.
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
    /// Evaluates the agent of the job, or the reactive controllers in a job without a training.
    Evaluate(Episodes),
    /// Enters the agents of the job, or a built-in policy, on a benchmark problem.
    Enter(Entry),
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

/// An entry on a benchmark problem.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Name of the problem.
    pub problem: String,
    /// Policy, with `{seed}` in place of a seed.
    pub policy: String,
    /// Training steps of an agent.
    pub steps: Option<u64>,
    /// Seeds, if not all of the problem.
    pub seeds: Vec<u64>,
    /// Test buildings, if not all of the problem.
    pub test: Vec<String>,
    /// The test episodes of one seed.
    pub episodes: Episodes,
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

    /// Returns the episodes that the job evaluates, of one seed.
    pub fn episodes(&self) -> Option<&Episodes> {
        self.actions.iter().find_map(|action| match action {
            Action::Evaluate(episodes) | Action::Enter(Entry { episodes, .. }) => Some(episodes),
            _ => None,
        })
    }

    /// Returns the SHA-256 of the actions: results of other actions are not those of this job.
    pub fn actions_sha256(&self) -> String {
        sha256(serde_json::to_vec(&self.actions).expect("plain data always serializes"))
    }

    /// Returns the first part of the key: the name of the agent.
    pub fn agent(&self) -> &str {
        self.key.split_once('/').map_or(&self.key, |(agent, _)| agent)
    }
}

/// Returns the training of an agent.
pub(crate) fn train(agent: &str, mut config: Table, steps: u64, seed: u64) -> Action {
    config.insert("steps".to_owned(), Value::Integer(steps as i64));
    config.insert("seed".to_owned(), Value::Integer(seed as i64));
    // The job evaluates the agent itself.
    let evaluation = config.entry("evaluation").or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(evaluation) = evaluation {
        evaluation.insert("whole_period".to_owned(), Value::Boolean(false));
    }
    Action::Train { agent: agent.to_owned(), config, steps }
}

pub(crate) fn texts(ids: &[BuildingId]) -> Vec<String> {
    ids.iter().map(ToString::to_string).collect()
}
