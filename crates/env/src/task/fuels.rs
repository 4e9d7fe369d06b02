//! Prices and emission factors by energy carrier and hour of the day.

use b2b_building::{Carrier, CarrierEnergy};
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

/// Default values of the fuels used only by imported models.
#[derive(Debug)]
pub(super) struct OtherFuels {
    propane: f64,
    fuel_oil: f64,
    other_fuel: f64,
}

/// Efficiency of the boilers and coefficient of performance of the chillers of a district.
const DISTRICT: [f64; 2] = [0.8, 5.0];

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
pub(super) const PRICES: Fuels = Fuels::of(0.127, 0.0365);
/// Rounded: propane at 2.7 $/gal, heating oil at 4 $/gal (US winter 2022-23), wood pellets at 300 $/ton.
pub(super) const PRICES_OF_OTHERS: OtherFuels =
    OtherFuels { propane: 0.10, fuel_oil: 0.10, other_fuel: 0.06 };
/// 0.373 kg/kWh: US grid average (EPA eGRID 2022, 823 lb/MWh); 0.181 kg/kWh: 53.06 kg per million Btu of natural gas
/// (40 CFR 98, table C-1). A default, to be replaced by local factors.
pub(super) const EMISSIONS: Fuels = Fuels::of(0.373, 0.181);
/// Also table C-1, kg per million Btu: propane 62.87, distillate fuel oil No. 2 73.96, wood 93.80 (coal: 94.27).
pub(super) const EMISSIONS_OF_OTHERS: OtherFuels =
    OtherFuels { propane: 0.215, fuel_oil: 0.252, other_fuel: 0.320 };

impl Fuels {
    const fn of(electricity: f64, gas: f64) -> Self {
        Self {
            electricity: Hourly::Always(electricity),
            gas: Hourly::Always(gas),
            propane: None,
            fuel_oil: None,
            other_fuel: None,
            district_heating: None,
            district_cooling: None,
        }
    }

    /// Returns the value of a carrier at an hour of the day, 0 to 24.
    fn at(&self, carrier: Carrier, hour: f64, others: &OtherFuels) -> f64 {
        let [boiler, chiller] = DISTRICT;
        let or = |own: &Option<Hourly>, default: f64| own.as_ref().map_or(default, |own| own.at(hour));
        match carrier {
            Carrier::Electricity => self.electricity.at(hour),
            Carrier::Gas => self.gas.at(hour),
            Carrier::Propane => or(&self.propane, others.propane),
            Carrier::FuelOil => or(&self.fuel_oil, others.fuel_oil),
            Carrier::OtherFuel => or(&self.other_fuel, others.other_fuel),
            Carrier::DistrictHeating => or(&self.district_heating, self.gas.at(hour) / boiler),
            Carrier::DistrictCooling => or(&self.district_cooling, self.electricity.at(hour) / chiller),
        }
    }

    /// Returns the sum over the carriers of energy times value at an hour of the day.
    pub(super) fn times(&self, energy: &CarrierEnergy, hour: f64, others: &OtherFuels) -> f64 {
        let of = |carrier: Carrier| energy[carrier as usize] * self.at(carrier, hour, others);
        Carrier::ALL.into_iter().map(of).sum()
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
