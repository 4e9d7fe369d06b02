//! The six building types.

mod data;
mod office_medium;
mod office_small;
mod restaurant_fast_food;
mod retail_standalone;
mod single_family_house;
mod warehouse;

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

pub use data::{Day, Prototype, TypeData};

/// A building type of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum BuildingType {
    /// Detached house, generated from scratch.
    SingleFamilyHouse,
    /// Small office: five zones with a heat pump each, and an attic.
    OfficeSmall,
    /// Medium office: fifteen zones on three floors, one air loop per floor.
    OfficeMedium,
    /// Stand-alone shop: four rooftop units and a heated entrance.
    RetailStandalone,
    /// Fast-food restaurant: dining room and kitchen with a rooftop unit each.
    RestaurantFastFood,
    /// Warehouse: office and fine storage with rooftop units, bulk storage with a unit heater.
    Warehouse,
}

impl BuildingType {
    /// Every type, in the order of the paper's table.
    pub const ALL: [Self; 6] = [
        Self::SingleFamilyHouse,
        Self::RestaurantFastFood,
        Self::Warehouse,
        Self::RetailStandalone,
        Self::OfficeSmall,
        Self::OfficeMedium,
    ];

    /// Returns the facts of the type.
    pub fn data(self) -> &'static TypeData {
        match self {
            Self::SingleFamilyHouse => &single_family_house::DATA,
            Self::OfficeSmall => &office_small::DATA,
            Self::OfficeMedium => &office_medium::DATA,
            Self::RetailStandalone => &retail_standalone::DATA,
            Self::RestaurantFastFood => &restaurant_fast_food::DATA,
            Self::Warehouse => &warehouse::DATA,
        }
    }

    /// Name, as in building ids.
    pub fn name(self) -> &'static str {
        self.data().name
    }

    /// One-line description.
    pub fn description(self) -> &'static str {
        self.data().description
    }

    /// The place of its base model.
    pub fn home(self) -> &'static str {
        self.data().home
    }

    /// Returns whether its buildings are houses, which are generated from parameters alone, all in Québec.
    pub fn is_house(self) -> bool {
        self.data().prototype.is_none()
    }
}

impl fmt::Display for BuildingType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Returns how alike two names are, from 0 to 1; words in another order, as in `SmallOffice`, count as alike.
fn likeness(known: &str, given: &str) -> f64 {
    let letters = |name: &str| {
        let mut letters: Vec<_> = name.chars().filter(|letter| letter.is_alphanumeric()).collect();
        letters.sort_unstable();
        letters.into_iter().collect::<String>()
    };
    let of_letters = strsim::normalized_damerau_levenshtein(&letters(known), &letters(given));
    strsim::jaro_winkler(known, given).max(of_letters)
}

impl FromStr for BuildingType {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|t| t.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let likeness = |t: &Self| likeness(&t.name().to_lowercase(), &text.to_lowercase());
            let near = Self::ALL.into_iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
            Error::UnknownType {
                text: text.to_owned(),
                near: near.filter(|near| likeness(near) > 0.8).map(Self::name),
                known: Self::ALL.map(Self::name).join(", "),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelled_type_gets_the_nearest() {
        for (text, near) in [
            ("SmallOffice", "OfficeSmall"),
            ("office-medium", "OfficeMedium"),
            ("Warehose", "Warehouse"),
            ("FastFoodRestaurant", "RestaurantFastFood"),
        ] {
            let said = text.parse::<BuildingType>().unwrap_err().to_string();
            assert!(said.contains(&format!("did you mean {near}?")), "{said}");
        }
        let said = "Castle".parse::<BuildingType>().unwrap_err().to_string();
        assert!(!said.contains("did you mean"), "{said}");
    }
}
