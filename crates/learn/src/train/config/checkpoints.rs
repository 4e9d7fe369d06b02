//! Checkpoints of a run, and the agent that it keeps.

use serde::{Deserialize, Serialize};

/// Which agent a run keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// The one with the best score in the evaluations during training, among those within the travel limit if any is.
    #[default]
    Best,
    /// The last one.
    Last,
}

/// Checkpoints of a run, and the agent that it keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CheckpointConfig {
    /// Which agent the run's folder keeps.
    pub keep: Keep,
    /// Steps between checkpoints; 0 for none but at the end.
    pub checkpoint_every: u64,
    /// Steps between stages, each of which keeps the agent as it was then; 0 for none.
    pub stage_every: u64,
}

impl Default for CheckpointConfig {
    fn default() -> Self {
        Self { keep: Keep::Best, checkpoint_every: 100_000, stage_every: 0 }
    }
}
