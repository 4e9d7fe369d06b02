//! The report of a worker at the end of an episode.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use b2b_env::EngineReport;

/// A worker's report of an episode whose engine finished its run: see
/// [`EpisodeOptions::finish_run`](crate::EpisodeOptions::finish_run).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EpisodeReport {
    /// The engine's side of the episode.
    pub engine: EngineReport,
    /// CPU time of the template's reset and of the worker up to the end of the episode.
    pub cpu: Duration,
}
