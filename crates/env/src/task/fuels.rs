//! Prices and emission factors by energy carrier and hour of the day.

use b2b_building::{Carrier, CarrierEnergy};
use b2b_tariff::FuelValues;
use serde::{Deserialize, Serialize};

/// A value for each energy carrier. Carriers used only by imported models may be omitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fuels {
    /// Electricity.
    pub electricity: Hourly,
    /// Natural gas.
    pub gas: Hourly,
    /// Propane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub propane: Option<Hourly>,
    /// Heating oil, diesel and gasoline.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fuel_oil: Option<Hourly>,
    /// Coal and other fuels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_fuel: Option<Hourly>,
    /// District hot water or steam. Default: the value for heat from a gas boiler.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub district_heating: Option<Hourly>,
    /// District chilled water. Default: the value for cooling from an electric chiller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub district_cooling: Option<Hourly>,
}

/// A constant value, or one value for each hour of the day from midnight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number, or a list of 24 numbers for the hours of the day")]
pub enum Hourly {
    /// The same all day.
    Always(f64),
    /// By hour of the day, standard time.
    Hours([f64; 24]),
}

/// US commercial consumers, 2023, rounded: 12.7 ¢/kWh of electricity (EIA, Electric Power Monthly). A default, to be
/// replaced by local prices.
pub(super) const PRICES: Fuels = Fuels::of(0.127, &FuelValues::PRICES);
/// 0.373 kg/kWh: US grid average (EPA eGRID 2022, 823 lb/MWh). A default, to be replaced by local factors.
pub(super) const EMISSIONS: Fuels = Fuels::of(0.373, &FuelValues::EMISSIONS);

impl Fuels {
    const fn of(electricity: f64, others: &FuelValues) -> Self {
        Self {
            electricity: Hourly::Always(electricity),
            gas: Hourly::Always(others.gas),
            propane: None,
            fuel_oil: None,
            other_fuel: None,
            district_heating: None,
            district_cooling: None,
        }
    }

    /// Returns the sum over the carriers of energy times value at an hour of the day, 0 to 24. `others` are the values
    /// of omitted carriers.
    pub(super) fn times(&self, energy: &CarrierEnergy, hour: f64, others: &FuelValues) -> f64 {
        let or = |own: &Option<Hourly>, default: f64| own.as_ref().map_or(default, |own| own.at(hour));
        let at = |own: &Option<Hourly>| own.as_ref().map(|own| own.at(hour));
        let electricity = self.electricity.at(hour);
        let values = FuelValues {
            gas: self.gas.at(hour),
            propane: or(&self.propane, others.propane),
            fuel_oil: or(&self.fuel_oil, others.fuel_oil),
            other_fuel: or(&self.other_fuel, others.other_fuel),
            district_heating: at(&self.district_heating),
            district_cooling: at(&self.district_cooling),
        };
        Carrier::ALL.into_iter().zip(energy).map(|(fuel, energy)| energy * values.at(fuel, electricity)).sum()
    }

    /// All given values.
    pub(super) fn values(&self) -> impl Iterator<Item = f64> {
        let optional =
            [&self.propane, &self.fuel_oil, &self.other_fuel, &self.district_heating, &self.district_cooling];
        let given = [&self.electricity, &self.gas].into_iter().chain(optional.into_iter().flatten());
        given.flat_map(Hourly::values).copied()
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
