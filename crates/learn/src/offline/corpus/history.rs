//! Agents at stages of their training, whose episodes are learning histories.

use std::fmt;
use std::path::{Path, PathBuf};

use b2b_building::BuildingType;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::train::TrainConfig;
use crate::{Error, Result};

/// Folder of the agents in a corpus.
pub(super) const AGENTS: &str = "agents";

/// Options of training that a history sets itself.
const SET: [&str; 3] = ["building_type", "task", "stage_every"];

/// One training run per building type, whose agent is kept at equally spaced stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// Name, part of the names of its policies.
    pub name: String,
    /// Task of the training and of the recorded episodes.
    pub task: String,
    /// Number of stages, the last at the end of training.
    pub stages: u64,
    /// Options of training, such as `preset` and `steps`.
    pub train: Table,
}

/// The policy of a stage of a history; `direct-2of4` in text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stage<'a> {
    pub(super) history: &'a History,
    /// From 1.
    pub(super) number: u64,
}

impl History {
    /// Returns the stages.
    pub(super) fn all_stages(&self) -> impl Iterator<Item = Stage<'_>> {
        (1..=self.stages).map(|number| Stage { history: self, number })
    }

    pub(super) fn check(&self, types: &[BuildingType]) -> std::result::Result<(), String> {
        let letters = self.name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '-');
        if self.name.is_empty() || !letters {
            return Err(format!("`name` of a history is `{}`; expected letters, digits and `-`", self.name));
        }
        if self.stages == 0 {
            return Err("`stages` is 0; expected at least 1".into());
        }
        if let Some(option) = SET.into_iter().find(|option| self.train.contains_key(*option)) {
            return Err(format!(
                "`train.{option}` of the history `{}` is set by the corpus; remove it",
                self.name
            ));
        }
        types.iter().try_for_each(|each| self.config(*each).map(drop)).map_err(|why| why.to_string())
    }

    /// Returns the configuration of the training for a type.
    pub(super) fn config(&self, building_type: BuildingType) -> Result<TrainConfig> {
        let mut options = self.train.clone();
        options.insert("building_type".into(), Value::String(building_type.to_string()));
        options.insert("task".into(), Value::String(self.task.clone()));
        let options = serde_json::to_string(&options).expect("a table serializes");
        let mut config = TrainConfig::of_json(&options, None, None)?;
        config.check()?;
        let (steps, stages) = (config.budget.steps, self.stages);
        if steps < stages {
            return Err(Error::Invalid(format!(
                "`steps` is {steps}; expected at least the {stages} `stages`"
            )));
        }
        config.checkpoints.stage_every = steps / stages;
        Ok(config)
    }
}

impl Stage<'_> {
    /// Returns the folder of its agent for a type in a corpus.
    pub(super) fn folder(self, corpus: &Path, building_type: BuildingType) -> PathBuf {
        corpus.join(AGENTS).join(format!("{building_type}-{self}"))
    }
}

impl fmt::Display for Stage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}of{}", self.history.name, self.number, self.history.stages)
    }
}
