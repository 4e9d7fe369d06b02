//! Evaluations during training.

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::limits::require;

/// Evaluations during training: deterministic episodes on a window of the run period, in separate processes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EvaluationConfig {
    /// Steps between evaluations; 0 for none.
    pub every: u64,
    /// Days of the window, in the middle of the run period.
    pub days: u32,
    /// Whether training episodes leave these days out, where the run period has room for episodes of `window_days`
    /// outside them.
    pub held_out: bool,
    /// Training buildings to evaluate on: at most this many, but at least one for every building type.
    pub buildings: usize,
    /// Whether the agent is scored over the whole run period when training ends.
    pub whole_period: bool,
}

impl Default for EvaluationConfig {
    fn default() -> Self {
        Self { every: 50_000, days: 14, held_out: true, buildings: 4, whole_period: true }
    }
}

impl EvaluationConfig {
    /// Checks the values.
    pub(super) fn check(&self) -> Result<()> {
        require(self.every == 0 || self.days > 0, || "`evaluation.days` is 0; expected at least 1".into())
    }
}
