//! The folder of a job.

use std::path::{Path, PathBuf};

use b2b_base::aside::write_whole;
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::error::{Result, at};

/// Configuration of the training.
pub const CONFIG: &str = "config.toml";
/// Entry on a benchmark problem.
pub const ENTRY: &str = "entry";
/// Evaluation of the agent that the training keeps.
pub const EVALUATION: &str = "evaluation";
/// Evaluation of the last agent of the training.
pub const EVALUATION_LAST: &str = "evaluation-last";
/// Output of a measurement.
pub const MEASURED: &str = "result.json";
/// The file that a finished training run leaves in its agent's folder.
const TRAINED: &str = "summary.json";
const STATE: &str = "job.json";
/// Wall-clock time of a job so far, s.
const SECONDS: &str = "seconds.json";
const LOG: &str = "log.txt";

/// The folder of a job, which need not exist.
#[derive(Clone, Debug)]
pub struct JobFolder {
    path: PathBuf,
}

/// The state of a job that has ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Why it failed; `None` if it succeeded.
    pub error: Option<String>,
    /// Wall-clock time of all attempts, s.
    pub seconds: f64,
    /// [`Job::actions_sha256`](crate::Job::actions_sha256); empty in older folders.
    #[serde(default)]
    pub actions_sha256: String,
}

impl JobFolder {
    /// Returns the folder at a path.
    pub fn at(path: PathBuf) -> Self {
        Self { path }
    }

    /// Returns its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the file with the output of the job's commands.
    pub fn log(&self) -> PathBuf {
        self.path.join(LOG)
    }

    /// Returns how the job ended; `None` if it has not.
    pub fn state(&self) -> Option<State> {
        self.read(STATE)
    }

    /// Writes how the job ended.
    pub fn set_state(&self, state: &State) -> Result<()> {
        write_json(&self.path.join(STATE), state)
    }

    /// Returns the wall-clock time of the job's commands so far, finished or interrupted, s; `None` if none has begun.
    pub fn seconds(&self) -> Option<f64> {
        self.read(SECONDS).or_else(|| Some(self.state()?.seconds))
    }

    /// Writes the wall-clock time that the job has taken so far.
    pub fn set_seconds(&self, seconds: f64) -> Result<()> {
        write_json(&self.path.join(SECONDS), &seconds)
    }

    /// Returns whether a training run has ended.
    pub fn is_trained(&self, agent: &str) -> bool {
        self.path.join(agent).join(TRAINED).exists()
    }

    /// Returns the steps per second of a finished training run, without evaluations.
    pub fn training_rate(&self, agent: &str) -> Option<f64> {
        #[derive(Deserialize)]
        struct Summary {
            steps_per_s: f64,
        }
        let summary: Summary = self.read(&format!("{agent}/{TRAINED}"))?;
        Some(summary.steps_per_s)
    }

    /// Returns the options of the training run that began last, as the experiment defined them.
    pub fn config(&self) -> Option<Table> {
        toml::from_str(&std::fs::read_to_string(self.path.join(CONFIG)).ok()?).ok()
    }

    /// Writes the options of a training.
    pub fn set_config(&self, config: &Table) -> Result<()> {
        let text = toml::to_string(config).expect("a table of plain values always serializes");
        let file = self.path.join(CONFIG);
        write_whole(&file, text.as_bytes()).map_err(at(&file))
    }

    fn read<T: for<'a> Deserialize<'a>>(&self, name: &str) -> Option<T> {
        serde_json::from_str(&std::fs::read_to_string(self.path.join(name)).ok()?).ok()
    }
}

/// Writes a JSON file atomically.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).expect("plain data always serializes") + "\n";
    write_whole(path, text.as_bytes()).map_err(at(path))
}
