//! Agents at stages of their training, whose episodes are learning histories.

use std::fmt;
use std::fs::{remove_dir_all, rename};
use std::path::{Path, PathBuf};
use std::time::Duration;

use b2b_agent::INFO;
use b2b_building::BuildingType;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::definition::Definition;
use super::writer::Writer;
use crate::error::at;
use crate::train::{STAGES, TrainConfig, acquire};
use crate::{Error, Result};

/// Folder of the agents in a corpus.
const AGENTS: &str = "agents";

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
        types.iter().try_for_each(|each| self.config(*each).map(drop)).map_err(|why| why.to_string())
    }

    /// Returns the configuration of the training for a type.
    fn config(&self, building_type: BuildingType) -> Result<TrainConfig> {
        let mut options = self.train.clone();
        options.insert("building_type".into(), Value::String(building_type.to_string()));
        options.insert("task".into(), Value::String(self.task.clone()));
        let options = toml::to_string(&options).expect("a table serializes");
        let mut config = TrainConfig::default().with_changes(&options).map_err(Error::Invalid)?;
        config.checkpoints.stage_every = config.budget.steps / self.stages;
        config.check()?;
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

/// Trains the agents of a corpus that are not there yet, one after the other. `train` carries out a configuration in a
/// folder, where it continues an interrupted run. Waits for another process that is training them.
///
/// # Errors
/// [`Error::Invalid`] for an unknown corpus or a folder that holds something else; [`Error::Interrupted`]; [`Error::Io`]; errors of `train`.
pub fn train_agents(
    name: &str,
    corpus: &Path,
    interrupted: fn() -> bool,
    train: &mut dyn FnMut(&TrainConfig, &Path) -> Result<()>,
) -> Result<()> {
    let definition = Definition::named(name)?;
    if definition.histories.is_empty() {
        return Ok(());
    }
    Writer::open(corpus, &definition)?;
    let folder = corpus.join(AGENTS);
    let _lock = acquire(&folder, Duration::MAX, interrupted)?;
    for (history, building_type) in definition.trainings() {
        let place = |stage: Stage<'_>| stage.folder(corpus, building_type);
        let left: Vec<_> = history.all_stages().filter(|stage| !place(*stage).join(INFO).exists()).collect();
        if left.is_empty() {
            continue;
        }
        let run = folder.join(format!(".b2b-unfinished-{building_type}-{}", history.name));
        train(&history.config(building_type)?, &run)?;
        for stage in left {
            let kept = run.join(STAGES).join(stage.number.to_string());
            rename(&kept, place(stage)).map_err(at(&kept))?;
        }
        remove_dir_all(&run).map_err(at(&run))?;
    }
    Ok(())
}
