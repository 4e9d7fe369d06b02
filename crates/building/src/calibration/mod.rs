//! Calibration of a model against monthly metered energy.
//!
//! [`Metered`] is the energy in a table; a [`Calibration`] finds, with [`fit`], the multipliers of a model's parameters
//! that make a simulation agree best with it, and [`Agreement`] has the statistics of ASHRAE Guideline 14.

mod agreement;
mod fit;
mod linear;
mod metered;
mod report;
mod search;

use std::fmt;

use serde::{Deserialize, Serialize};

pub use agreement::Agreement;
pub use fit::{Fit, Options, fit};
pub use metered::Metered;
pub use report::{FuelReport, Parameter, Report};
pub use search::{Calibration, Progress};

use crate::edit::Change;

/// A metered fuel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fuel {
    /// Electricity.
    Electricity,
    /// Natural gas.
    Gas,
}

impl Fuel {
    /// All fuels.
    pub const ALL: [Self; 2] = [Self::Electricity, Self::Gas];

    /// Returns the engine's meter of the whole building.
    pub fn meter(self) -> &'static str {
        match self {
            Self::Electricity => "Electricity:Facility",
            Self::Gas => "NaturalGas:Facility",
        }
    }

    /// Returns the column of a table of metered energy.
    pub fn column(self) -> &'static str {
        match self {
            Self::Electricity => "electricity_kwh",
            Self::Gas => "gas_kwh",
        }
    }
}

impl fmt::Display for Fuel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Electricity => "electricity",
            Self::Gas => "gas",
        })
    }
}

/// The changes whose multipliers can be calibrated.
pub const PARAMETERS: [Change; 7] = [
    Change::Infiltration,
    Change::Lights,
    Change::Equipment,
    Change::People,
    Change::WallU,
    Change::RoofU,
    Change::WindowU,
];

/// The changes that are calibrated by default.
pub const DEFAULT_PARAMETERS: [Change; 4] =
    [Change::Infiltration, Change::Lights, Change::Equipment, Change::WallU];

/// Lowest and highest multiplier.
pub const MULTIPLIERS: [f64; 2] = [0.2, 5.0];
