//! Energy carriers.

use serde::{Deserialize, Serialize};

/// An energy carrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Carrier {
    /// Electricity.
    Electricity,
    /// Natural gas.
    Gas,
    /// Propane.
    Propane,
    /// Heating oil, diesel and gasoline.
    FuelOil,
    /// Coal, and the engine's `OtherFuel1` and `OtherFuel2`.
    OtherFuel,
    /// Hot water or steam of a district.
    DistrictHeating,
    /// Chilled water of a district.
    DistrictCooling,
}

/// An amount of energy for each carrier, in the order of [`Carrier::ALL`].
pub type CarrierEnergy = [f64; Carrier::ALL.len()];

impl Carrier {
    /// All carriers.
    pub const ALL: [Self; 7] = [
        Self::Electricity,
        Self::Gas,
        Self::Propane,
        Self::FuelOil,
        Self::OtherFuel,
        Self::DistrictHeating,
        Self::DistrictCooling,
    ];

    /// Returns its name, for example `fuel oil`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Electricity => "electricity",
            Self::Gas => "gas",
            Self::Propane => "propane",
            Self::FuelOil => "fuel oil",
            Self::OtherFuel => "other fuels",
            Self::DistrictHeating => "district heating",
            Self::DistrictCooling => "district cooling",
        }
    }
}
