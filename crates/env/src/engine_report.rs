//! The engine's report of a finished run.

use serde::{Deserialize, Serialize};

/// A part of the bill of an episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BillPart {
    /// Name of a price of the tariff, a demand charge or a carrier.
    pub name: String,
    /// kWh of energy, or kW of a demand charge, of the HVAC of the whole building.
    pub quantity: f64,
    /// `kWh` or `kW`.
    pub unit: String,
    /// Cost in the tariff's currency.
    pub cost: f64,
}

/// The engine's side of a finished episode, with its bill.
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
    /// HVAC electricity and other HVAC energy over the run period from EnergyPlus's own meters, Wh/m². `None` if the
    /// engine did not finish its run.
    pub meters: Option<[f64; 2]>,
    /// Names of the controlled zones that are never occupied: occupancy setpoints always leave them at the unoccupied
    /// target.
    pub never_occupied: Vec<String>,
    /// Parts of the bill; none without a tariff.
    #[serde(default)]
    pub bill: Vec<BillPart>,
}
