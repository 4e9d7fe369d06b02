//! What the engine has to say of a finished run.

use serde::{Deserialize, Serialize};

/// The engine's side of a finished episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EngineReport {
    /// Number of warnings.
    pub warnings: usize,
    /// Number of severe messages.
    pub severes: usize,
    /// The first severe and fatal messages.
    pub severe_messages: Vec<String>,
    /// HVAC electricity and gas over the run period by EnergyPlus's own meters, Wh/m². `None` where the engine wrote
    /// none, after a restore.
    pub meters: Option<[f64; 2]>,
    /// Controlled zones in which nobody ever is, by name: occupancy setpoints always leave them at the unoccupied
    /// target.
    pub never_occupied: Vec<String>,
}
