//! Classes of buildings: a type in a climate zone. Measurements on some buildings of a class are used for all of them.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::BuildingType;

/// A building type in a climate zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Class {
    /// The type.
    pub building_type: BuildingType,
    /// Thermal zone of ASHRAE 169, 1 to 8. `None` for houses, which are all in Québec and form one class, and if it is
    /// unknown.
    pub climate_zone: Option<u8>,
}

impl Class {
    /// Returns the class of a type in a climate zone, for example `5B` or `7`. Zone 0 counts as zone 1.
    pub fn new(building_type: BuildingType, ashrae_zone: Option<&str>) -> Self {
        let digit = ashrae_zone.and_then(|zone| zone.chars().next()?.to_digit(10)).map(|zone| zone as u8);
        let climate_zone = digit.filter(|_| !building_type.is_house()).map(|zone| zone.clamp(1, 8));
        Self { building_type, climate_zone }
    }

    /// Returns every class of the dataset: houses, and the other types in zones 1 to 8.
    pub fn all() -> impl Iterator<Item = Self> {
        BuildingType::ALL.into_iter().flat_map(|building_type| {
            let zones = if building_type.is_house() { vec![None] } else { (1..=8).map(Some).collect() };
            zones.into_iter().map(move |climate_zone| Self { building_type, climate_zone })
        })
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.climate_zone {
            Some(zone) => write!(f, "{} in zone {zone}", self.building_type),
            None => self.building_type.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_is_a_type_and_a_thermal_zone_and_houses_form_one() {
        let zone = |zone| Class::new(BuildingType::Warehouse, zone).climate_zone;
        assert_eq!([Some("5B"), Some("8"), Some("0A"), None].map(zone), [Some(5), Some(8), Some(1), None]);
        assert_eq!(Class::new(BuildingType::SingleFamilyHouse, Some("6A")).climate_zone, None);
        assert_eq!(Class::all().count(), 41);
        assert_eq!(Class::new(BuildingType::Warehouse, Some("5B")).to_string(), "Warehouse in zone 5");
    }
}
