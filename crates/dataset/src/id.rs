//! Building ids.

use std::fmt;
use std::str::FromStr;

use b2b_building::BuildingType;

use crate::{Error, Result};

/// Number of buildings of each type in the dataset.
pub const BUILDINGS_PER_TYPE: u32 = 1000;

/// The id of a building of the dataset, for example `OfficeSmall-0042`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BuildingId {
    building_type: BuildingType,
    number: u32,
}

impl BuildingId {
    /// The id of a type and a number from 1 to [`BUILDINGS_PER_TYPE`].
    ///
    /// # Errors
    /// [`Error::BuildingNumber`] when the number is out of range.
    pub fn new(building_type: BuildingType, number: u32) -> Result<Self> {
        if (1..=BUILDINGS_PER_TYPE).contains(&number) {
            return Ok(Self { building_type, number });
        }
        Err(unknown(building_type, &number.to_string()))
    }

    /// Returns the type.
    pub fn building_type(self) -> BuildingType {
        self.building_type
    }

    /// Returns the number, from 1 to [`BUILDINGS_PER_TYPE`].
    pub fn number(self) -> u32 {
        self.number
    }
}

impl fmt::Display for BuildingId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{:04}", self.building_type, self.number)
    }
}

impl FromStr for BuildingId {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (building_type, number) =
            text.split_once('-').ok_or_else(|| Error::BuildingId { text: text.to_owned() })?;
        let building_type: BuildingType = building_type.parse()?;
        let digits = |text: &&str| text.bytes().all(|byte| byte.is_ascii_digit());
        let parsed = Some(number).filter(digits).and_then(|number| number.parse().ok());
        parsed
            .and_then(|number| Self::new(building_type, number).ok())
            .ok_or_else(|| unknown(building_type, number))
    }
}

fn unknown(building_type: BuildingType, number: &str) -> Error {
    Error::BuildingNumber { building_type, number: number.to_owned(), last: BUILDINGS_PER_TYPE }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_round_trips_through_text() {
        for building_type in BuildingType::ALL {
            for number in [1, 42, 1000] {
                let id = BuildingId::new(building_type, number).unwrap();
                assert_eq!(id.to_string().parse::<BuildingId>().unwrap(), id);
            }
        }
        assert_eq!("officesmall-42".parse::<BuildingId>().unwrap().to_string(), "OfficeSmall-0042");
    }

    #[test]
    fn the_error_of_an_invalid_id_names_valid_ones() {
        for (text, words) in [
            ("OfficeSmall", ["`OfficeSmall`", "OfficeSmall-0042"]),
            ("OficeSmall-0042", ["OficeSmall", "OfficeSmall"]),
            ("OfficeSmall-0000", ["0000", "1000"]),
            ("OfficeSmall-1001", ["1001", "1000"]),
            ("Warehouse-99999999999", ["99999999999", "1000"]),
            ("Warehouse-+7", ["+7", "Warehouse-0001"]),
            ("Warehouse-", ["`Warehouse-`", "Warehouse-0001"]),
        ] {
            let said = text.parse::<BuildingId>().unwrap_err().to_string();
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
        }
    }
}
