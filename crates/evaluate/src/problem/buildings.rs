//! The buildings of a side.

use std::fmt;
use std::str::FromStr;

use b2b_building::BuildingType;
use b2b_dataset::{BuildingId, Row};
use serde::{Deserialize, Serialize};

use super::as_text;
use super::list::joined;

/// Buildings of the dataset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "BuildingsFile")]
pub enum Buildings {
    /// Buildings by id.
    Listed {
        /// The ids.
        #[serde(with = "as_text::list")]
        ids: Vec<BuildingId>,
    },
    /// A subset of some building types.
    Subset {
        /// The types.
        #[serde(with = "as_text::list")]
        types: Vec<BuildingType>,
        /// The subset.
        #[serde(rename = "split")]
        subset: Subset,
        /// Number of buildings, spread evenly over the types and their locations; `None` for all.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        count: Option<usize>,
    },
}

/// [`Buildings`] in a file, deserialized separately for better error messages.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BuildingsFile {
    ids: Option<Vec<String>>,
    types: Option<Vec<String>>,
    split: Option<Subset>,
    count: Option<usize>,
}

impl TryFrom<BuildingsFile> for Buildings {
    type Error = String;

    fn try_from(file: BuildingsFile) -> Result<Self, String> {
        match file {
            BuildingsFile { ids: Some(ids), types: None, split: None, count: None } => {
                Ok(Self::Listed { ids: parsed(&ids)? })
            }
            BuildingsFile { ids: None, types: Some(types), split: Some(subset), count } => {
                Ok(Self::Subset { types: parsed(&types)?, subset, count })
            }
            _ => {
                Err(r#"expected {"ids": [...]} or {"types": [...], "split": "train", "count": 20}"#
                    .to_owned())
            }
        }
    }
}

fn parsed<T: FromStr<Err: fmt::Display>>(texts: &[String]) -> Result<Vec<T>, String> {
    texts.iter().map(|text| text.parse().map_err(|error: T::Err| error.to_string())).collect()
}

/// A subset of the dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Subset {
    /// The train split: 90 % of the buildings of each location.
    Train,
    /// The test split: 10 % of the buildings of each location.
    Test,
    /// Eight test buildings per type, one for each climate zone (houses: spread over the regions).
    TestSmall,
}

impl Buildings {
    /// Returns the ids, in the order of the dataset or of the list.
    pub fn ids(&self) -> Vec<BuildingId> {
        match self {
            Self::Listed { ids } => ids.clone(),
            Self::Subset { types, subset, count } => {
                let of_type = types.iter().flat_map(|building_type| b2b_dataset::rows(*building_type));
                let all: Vec<_> = of_type.filter(|row| subset.contains(row)).map(|row| row.id).collect();
                match count {
                    Some(count) => spread(&all, types, *count),
                    None => all,
                }
            }
        }
    }

    /// Returns the building types in order of first appearance.
    pub fn types(&self) -> Vec<BuildingType> {
        let of = match self {
            Self::Listed { ids } => ids.iter().map(|id| id.building_type()).collect(),
            Self::Subset { types, .. } => types.clone(),
        };
        let mut types = Vec::new();
        for building_type in of {
            if !types.contains(&building_type) {
                types.push(building_type);
            }
        }
        types
    }

    /// Returns `count` of the buildings, spread evenly over each type; all if there are fewer.
    pub fn sample(&self, count: usize) -> Vec<BuildingId> {
        spread(&self.ids(), &self.types(), count)
    }
}

/// Returns `count` of some buildings of these types, spread evenly over each type; all if there are fewer.
fn spread(all: &[BuildingId], types: &[BuildingType], count: usize) -> Vec<BuildingId> {
    let share = |number: usize| count * (number + 1) / types.len() - count * number / types.len();
    let of_type = types.iter().enumerate().flat_map(|(number, building_type)| {
        let own: Vec<_> = all.iter().filter(|id| id.building_type() == *building_type).collect();
        let wanted = share(number).min(own.len());
        (0..wanted).map(move |place| *own[(2 * place + 1) * own.len() / (2 * wanted)]).collect::<Vec<_>>()
    });
    of_type.collect()
}

impl Subset {
    fn contains(self, row: &Row) -> bool {
        match self {
            Self::Train => row.split == b2b_dataset::Split::Train,
            Self::Test => row.split == b2b_dataset::Split::Test,
            Self::TestSmall => row.test_small,
        }
    }
}

impl fmt::Display for Subset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Train => "train",
            Self::Test => "test",
            Self::TestSmall => "test_small",
        })
    }
}

impl fmt::Display for Buildings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Listed { ids } => write!(f, "{}", joined(ids)),
            Self::Subset { types, subset, .. } => {
                write!(f, "{}, {subset} split ({} buildings)", joined(types), self.ids().len())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_spread_evenly_and_of_every_type() {
        let types = vec![BuildingType::Warehouse, BuildingType::OfficeSmall];
        let buildings = Buildings::Subset { types, subset: Subset::Train, count: None };
        let sample = buildings.sample(20);
        assert_eq!(sample.len(), 20);
        assert_eq!(sample.iter().filter(|id| id.building_type() == BuildingType::Warehouse).count(), 10);
        let numbers: Vec<_> = sample[..10].iter().map(|id| id.number()).collect();
        assert!(numbers.is_sorted() && numbers[0] < 100 && numbers[9] > 900, "{numbers:?}");
        assert_eq!(buildings.sample(usize::MAX >> 8).len(), buildings.ids().len());
        assert_eq!(buildings.sample(0), []);
    }
}
