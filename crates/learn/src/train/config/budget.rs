//! The size of a run.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// The size of a run, and its random seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Budget {
    /// Environment steps, all environments together.
    pub steps: u64,
    /// Random seed.
    pub seed: u64,
    /// Number of environments.
    pub environments: usize,
}

impl Default for Budget {
    fn default() -> Self {
        Self { steps: 500_000, seed: 0, environments: 14 }
    }
}

impl Budget {
    /// Checks the values.
    pub(super) fn check(&self) -> Result<()> {
        let counts = [("environments", self.environments as u64), ("steps", self.steps)];
        match counts.into_iter().find(|(_, count)| *count == 0) {
            Some((name, count)) => Err(Error::config(name, count, "expected at least 1")),
            None => Ok(()),
        }
    }
}
