//! The engine's report of a finished run.

use serde::{Deserialize, Serialize};

/// The engine's side of a finished episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EngineReport {
    /// Number of warnings.
    pub warnings: usize,
    /// Number of severe messages.
    pub severes: usize,
    /// The first warnings.
    pub warning_messages: Vec<String>,
    /// The first severe and fatal messages.
    pub severe_messages: Vec<String>,
    /// HVAC electricity and gas over the run period by EnergyPlus's own meters, Wh/m². `None` where the engine wrote
    /// none, after a restore.
    pub meters: Option<[f64; 2]>,
    /// Names of the controlled zones that are never occupied: occupancy setpoints always leave them at the unoccupied
    /// target.
    pub never_occupied: Vec<String>,
}
