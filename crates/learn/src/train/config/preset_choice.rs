//! The preset of a run that names none.

use std::path::Path;

use b2b_agent::Acting;
use b2b_env::Task;
use serde::Deserialize;
use toml::Value;

use super::agent::text_or_table;
use super::file::read_table;
use super::one_or_many;
use super::tasks::Tasks;
use crate::error::Result;

/// The options that decide on the preset of a run.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct PresetChoice {
    /// Name of the preset.
    pub preset: Option<String>,
    /// Tasks of the run.
    pub task: Option<Tasks>,
    /// How the agent acts.
    #[serde(deserialize_with = "some_acting")]
    pub acting: Option<Acting>,
    /// Training buildings by name.
    #[serde(deserialize_with = "one_or_many::deserialize")]
    pub buildings: Vec<String>,
    /// Building types from whose training splits buildings are drawn.
    #[serde(deserialize_with = "one_or_many::deserialize")]
    pub building_type: Vec<String>,
    /// Benchmark problem that the agent is for; empty: none.
    pub problem: String,
}

impl PresetChoice {
    /// Returns the name of the preset: the one that these options or a file name, otherwise `supervisory` with
    /// supervision and in operation, there with a building type `supervisory-graph`, otherwise `residual`. These options
    /// take precedence over the file's.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::ConfigFile`](crate::Error::ConfigFile) for a file that is not TOML.
    pub fn name(self, file: Option<&Path>) -> Result<String> {
        // What is invalid is reported when the file is applied to the preset.
        let read = |table| Ok(Value::Table(table).try_into().unwrap_or_default());
        let all = match file {
            Some(path) => self.or(read_table(path, read)?),
            None => self,
        };
        let tasks = all.task.unwrap_or_default();
        let supervises = match all.acting {
            Some(acting) => acting.is_supervision(),
            None => all.problem.is_empty() && tasks.as_slice().iter().all(Task::is_operation),
        };
        let default = match (supervises, all.building_type.is_empty()) {
            (false, _) => "residual",
            (true, true) => "supervisory",
            (true, false) => "supervisory-graph",
        };
        Ok(all.preset.unwrap_or_else(|| default.into()))
    }

    /// Returns these options, with those of a file where they are absent.
    fn or(self, file: Self) -> Self {
        // Buildings and a type replace each other.
        let is_open = self.buildings.is_empty() && self.building_type.is_empty();
        Self {
            preset: self.preset.or(file.preset),
            task: self.task.or(file.task),
            acting: self.acting.or(file.acting),
            building_type: if is_open { file.building_type } else { self.building_type },
            problem: if self.problem.is_empty() { file.problem } else { self.problem },
            buildings: self.buildings,
        }
    }
}

fn some_acting<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Option<Acting>, D::Error> {
    text_or_table(deserializer).map(Some)
}
