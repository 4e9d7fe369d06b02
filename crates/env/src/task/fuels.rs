//! Prices and emission factors by fuel and hour of the day.

use serde::{Deserialize, Serialize};

/// A value for each fuel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fuels {
    /// Electricity.
    pub electricity: Hourly,
    /// Natural gas.
    pub gas: Hourly,
}

/// A constant value, or one value for each hour of the day from midnight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Hourly {
    /// The same all day.
    Always(f64),
    /// By hour of the day, standard time.
    Hours([f64; 24]),
}

/// US commercial consumers, 2023, rounded: 12.7 ¢/kWh of electricity, $11.1 per thousand cubic feet of gas (EIA, Electric
/// Power Monthly and Natural Gas Monthly). A default, to be replaced by local prices.
pub(super) const PRICES: Fuels = Fuels { electricity: Hourly::Always(0.127), gas: Hourly::Always(0.0365) };
/// 0.373 kg/kWh: US grid average (EPA eGRID 2022, 823 lb/MWh); 0.181 kg/kWh: 53.06 kg per million Btu of natural gas
/// (40 CFR 98, table C-1). A default, to be replaced by local factors.
pub(super) const EMISSIONS: Fuels = Fuels { electricity: Hourly::Always(0.373), gas: Hourly::Always(0.181) };

impl Fuels {
    /// All values of both fuels.
    pub(super) fn values(&self) -> impl Iterator<Item = f64> {
        self.electricity.values().iter().chain(self.gas.values()).copied()
    }
}

impl Hourly {
    /// Returns the value at an hour of the day, 0 to 24.
    pub fn at(&self, hour: f64) -> f64 {
        match self {
            Self::Always(value) => *value,
            Self::Hours(hours) => hours[(hour as usize) % 24],
        }
    }

    fn values(&self) -> &[f64] {
        match self {
            Self::Always(value) => std::slice::from_ref(value),
            Self::Hours(hours) => hours,
        }
    }
}
