//! The six building types.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

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

    /// Name, as in building ids.
    pub fn name(self) -> &'static str {
        match self {
            Self::SingleFamilyHouse => "SingleFamilyHouse",
            Self::OfficeSmall => "OfficeSmall",
            Self::OfficeMedium => "OfficeMedium",
            Self::RetailStandalone => "RetailStandalone",
            Self::RestaurantFastFood => "RestaurantFastFood",
            Self::Warehouse => "Warehouse",
        }
    }

    /// One-line description.
    pub fn description(self) -> &'static str {
        match self {
            Self::SingleFamilyHouse => "detached Québec house, ducted heat pump or furnace with cooling",
            Self::OfficeSmall => "small office, a heat pump for each of five zones",
            Self::OfficeMedium => "medium office, three central air loops over fifteen zones",
            Self::RetailStandalone => "shop, four rooftop units and a heated entrance",
            Self::RestaurantFastFood => "fast-food restaurant, rooftop units for dining room and kitchen",
            Self::Warehouse => "warehouse, two rooftop units and a unit heater",
        }
    }

    /// The place of its base model.
    pub fn home(self) -> &'static str {
        match self {
            Self::SingleFamilyHouse => "Montréal",
            _ => "Denver",
        }
    }
}

impl fmt::Display for BuildingType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for BuildingType {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|t| t.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let near =
                |t: &&Self| strsim::jaro_winkler(&t.name().to_lowercase(), &text.to_lowercase()) > 0.75;
            Error::UnknownType {
                text: text.to_owned(),
                near: Self::ALL.iter().find(near).map(|t| t.name()),
                known: Self::ALL.map(Self::name).join(", "),
            }
        })
    }
}
