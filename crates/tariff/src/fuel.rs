//! Values of energy carriers, and defaults for carriers that a tariff or an emission profile leaves out.

use b2b_base::carrier::Carrier;
use serde::Deserialize;
use toml::Spanned;

use crate::error::Fault;

/// Efficiency of the boilers of a district.
const BOILER: f64 = 0.8;
/// Coefficient of performance of the chillers of a district.
const CHILLER: f64 = 5.0;

/// Values of the carriers other than electricity, as a file gives them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fuels {
    gas: Option<f64>,
    propane: Option<f64>,
    fuel_oil: Option<f64>,
    other_fuel: Option<f64>,
    district_heating: Option<f64>,
    district_cooling: Option<f64>,
}

/// Values of the carriers other than electricity, per kWh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuelValues {
    /// Natural gas.
    pub gas: f64,
    /// Propane.
    pub propane: f64,
    /// Heating oil, diesel and gasoline.
    pub fuel_oil: f64,
    /// Coal, wood and other fuels.
    pub other_fuel: f64,
    /// District heat. Default: the value for heat from a gas boiler.
    pub district_heating: Option<f64>,
    /// District cooling. Default: the value for cooling from an electric chiller.
    pub district_cooling: Option<f64>,
}

/// Returns the name of a carrier on a bill.
pub(crate) fn label(carrier: Carrier) -> &'static str {
    match carrier {
        Carrier::Gas => "natural gas",
        Carrier::OtherFuel => "other fuel",
        named => named.name(),
    }
}

impl FuelValues {
    /// US dollars per kWh, rounded: natural gas of US commercial consumers, 2023, 11.1 $ per thousand cubic feet (EIA,
    /// Natural Gas Monthly); propane at 2.7 $/gal and heating oil at 4 $/gal (US winter 2022-23), wood pellets at
    /// 300 $/ton.
    pub const PRICES: Self = Self::of([0.0365, 0.10, 0.10, 0.06]);
    /// kg of CO₂ per kWh, rounded: 40 CFR 98, table C-1, kg per million Btu: natural gas 53.06, propane 62.87,
    /// distillate fuel oil No. 2 73.96, wood 93.80 (coal: 94.27).
    pub const EMISSIONS: Self = Self::of([0.181, 0.215, 0.252, 0.320]);

    const fn of([gas, propane, fuel_oil, other_fuel]: [f64; 4]) -> Self {
        Self { gas, propane, fuel_oil, other_fuel, district_heating: None, district_cooling: None }
    }

    /// Returns these values, replaced by the ones that a file may give, up to a limit.
    ///
    /// # Errors
    /// A fault at the file's values for one that is negative, not finite or beyond the limit.
    pub(crate) fn with(self, given: Option<&Spanned<Fuels>>, most: Option<f64>) -> Result<Self, Fault> {
        let Some(spanned) = given else { return Ok(self) };
        let given = spanned.get_ref();
        let named = [
            ("gas", given.gas),
            ("propane", given.propane),
            ("fuel_oil", given.fuel_oil),
            ("other_fuel", given.other_fuel),
            ("district_heating", given.district_heating),
            ("district_cooling", given.district_cooling),
        ];
        for (name, value) in named {
            let highest = most.unwrap_or(f64::MAX);
            if let Some(value) = value.filter(|value| !(0.0..=highest).contains(value)) {
                let expected =
                    most.map_or("a number of at least 0".into(), |most| format!("0 to {most} kg/kWh"));
                let why = format!("`{name}` is {value}; expected {expected}");
                return Err(Fault::at(spanned.span().start, why));
            }
        }
        Ok(Self {
            gas: given.gas.unwrap_or(self.gas),
            propane: given.propane.unwrap_or(self.propane),
            fuel_oil: given.fuel_oil.unwrap_or(self.fuel_oil),
            other_fuel: given.other_fuel.unwrap_or(self.other_fuel),
            district_heating: given.district_heating,
            district_cooling: given.district_cooling,
        })
    }

    /// Returns the value of a carrier for a given value of electricity.
    pub fn at(&self, carrier: Carrier, electricity: f64) -> f64 {
        match carrier {
            Carrier::Electricity => electricity,
            Carrier::Gas => self.gas,
            Carrier::Propane => self.propane,
            Carrier::FuelOil => self.fuel_oil,
            Carrier::OtherFuel => self.other_fuel,
            Carrier::DistrictHeating => self.district_heating.unwrap_or(self.gas / BOILER),
            Carrier::DistrictCooling => self.district_cooling.unwrap_or(electricity / CHILLER),
        }
    }
}
