//! The result of a run.

use std::path::{Path, PathBuf};

use b2b_base::aside::write_whole;
use serde::Serialize;

use super::judge::AgentScores;
use crate::error::{Result, at};

/// Name of the result in a run's folder.
pub const SUMMARY: &str = "summary.json";

/// The result of a run.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// Scores of the agent in the run's folder over the whole run period, without exploration; `None` without
    /// `evaluation.whole_period`.
    #[serde(flatten)]
    pub scores: Option<AgentScores>,
    /// Environment steps.
    pub steps: u64,
    /// Environment steps per second of training, without evaluations.
    pub steps_per_s: f64,
    /// Random seed.
    pub seed: u64,
    /// Training buildings.
    pub buildings: String,
    /// Task.
    pub task: String,
    /// Run period.
    pub period: String,
    /// Episodes that were lost.
    pub lost_episodes: u64,
    /// The run's folder, which is the agent's.
    pub out: PathBuf,
}

impl RunSummary {
    /// Writes the result to a run's folder.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let text = serde_json::to_vec_pretty(self).expect("plain data always serializes");
        let path = folder.join(SUMMARY);
        write_whole(&path, &text).map_err(at(&path))
    }
}
