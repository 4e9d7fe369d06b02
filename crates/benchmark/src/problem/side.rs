//! One side of a problem: which buildings, which tasks, and which of the actuators.

use std::fmt;
use std::str::FromStr;

use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::{BuildingId, BuildingName, Row};
use b2b_env::{Spaces, Task};
use serde::{Deserialize, Serialize};

use super::restriction::Restriction;
use super::spelled;
use crate::{Episode, Subject};

/// What a policy is trained on, or tested on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Side {
    /// The buildings.
    pub buildings: Buildings,
    /// The tasks, each in every building.
    #[serde(with = "spelled::list")]
    pub tasks: Vec<Task>,
    /// What is taken away from the action, if anything is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restriction: Option<Restriction>,
    /// What its buildings have to be, checked when they are run. Empty where nothing is known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sizes: Vec<Size>,
}

/// Buildings of the dataset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Written")]
pub enum Buildings {
    /// These.
    Listed {
        /// Their ids.
        #[serde(with = "spelled::list")]
        ids: Vec<BuildingId>,
    },
    /// All of some types that are for the same use.
    Part {
        /// The types.
        #[serde(with = "spelled::list")]
        types: Vec<BuildingType>,
        /// Which of them.
        split: Part,
    },
}

/// Buildings as a file has them: read in a way that says what is wrong with them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    ids: Option<Vec<String>>,
    types: Option<Vec<String>>,
    split: Option<Part>,
}

impl TryFrom<Written> for Buildings {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        match written {
            Written { ids: Some(ids), types: None, split: None } => Ok(Self::Listed { ids: parsed(&ids)? }),
            Written { ids: None, types: Some(types), split: Some(split) } => {
                Ok(Self::Part { types: parsed(&types)?, split })
            }
            _ => Err(r#"give {"ids": [...]}, or {"types": [...], "split": "train"}"#.to_owned()),
        }
    }
}

fn parsed<T: FromStr<Err: fmt::Display>>(texts: &[String]) -> Result<Vec<T>, String> {
    texts.iter().map(|text| text.parse().map_err(|error: T::Err| error.to_string())).collect()
}

/// A part of the dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// Nine tenths of every place, to learn on.
    Train,
    /// The other tenth, to test on.
    Test,
    /// Eight of the test a type, one for each climate zone.
    TestSmall,
}

/// The sizes of a type's spaces, as the paper's tables have them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Size {
    /// The type.
    #[serde(rename = "type", with = "spelled")]
    pub building_type: BuildingType,
    /// Slots of the observation, at least and at most: houses have attics and garages or not, and where targets move
    /// there are more slots.
    pub observation: [usize; 2],
    /// Actuators, without those that are taken away.
    pub action: usize,
}

impl Buildings {
    /// The ids, in the order of the dataset or of the list.
    pub fn ids(&self) -> Vec<BuildingId> {
        match self {
            Self::Listed { ids } => ids.clone(),
            Self::Part { types, split } => {
                let of_type = types.iter().flat_map(|building_type| b2b_dataset::rows(*building_type));
                of_type.filter(|row| split.has(row)).map(|row| row.id).collect()
            }
        }
    }

    /// Their types, in the order in which they come first.
    pub fn types(&self) -> Vec<BuildingType> {
        let of = match self {
            Self::Listed { ids } => ids.iter().map(|id| id.building_type()).collect(),
            Self::Part { types, .. } => types.clone(),
        };
        let mut types = Vec::new();
        for building_type in of {
            if !types.contains(&building_type) {
                types.push(building_type);
            }
        }
        types
    }

    /// So many of them, spread evenly over each type; all where there are fewer.
    pub fn sample(&self, count: usize) -> Vec<BuildingId> {
        let (all, types) = (self.ids(), self.types());
        let share = |number: usize| count * (number + 1) / types.len() - count * number / types.len();
        let spread = types.iter().enumerate().flat_map(|(number, building_type)| {
            let own: Vec<_> = all.iter().filter(|id| id.building_type() == *building_type).collect();
            let wanted = share(number).min(own.len());
            (0..wanted).map(move |place| *own[(2 * place + 1) * own.len() / (2 * wanted)]).collect::<Vec<_>>()
        });
        spread.collect()
    }
}

impl Part {
    fn has(self, row: &Row) -> bool {
        match self {
            Self::Train => row.split == b2b_dataset::Split::Train,
            Self::Test => row.split == b2b_dataset::Split::Test,
            Self::TestSmall => row.test_small,
        }
    }
}

impl fmt::Display for Part {
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
            Self::Listed { ids } => write!(f, "{}", words(ids)),
            Self::Part { types, split } => {
                write!(f, "{} of split {split} ({} buildings)", words(types), self.ids().len())
            }
        }
    }
}

/// Things one after another, with commas.
pub(super) fn words<T: fmt::Display>(all: &[T]) -> String {
    all.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

impl Side {
    /// The episodes of some of its buildings: building by building, then by window, task and seed.
    pub fn episodes(
        &self,
        buildings: &[BuildingId],
        windows: &[RunPeriod],
        seeds: &[u64],
        steps_per_hour: u32,
    ) -> Vec<Episode> {
        let mut episodes = Vec::new();
        for id in buildings {
            for period in windows {
                for task in &self.tasks {
                    for seed in seeds {
                        episodes.push(Episode {
                            subject: Subject::at_home(BuildingName::Id(*id)),
                            task: task.clone(),
                            period: *period,
                            seed: *seed,
                            steps_per_hour,
                        });
                    }
                }
            }
        }
        episodes
    }

    /// What is wrong with the sizes of a building, if anything is.
    pub(super) fn misfit(
        &self,
        building_type: BuildingType,
        spaces: &Spaces,
        actuators: usize,
    ) -> Option<String> {
        let size = self.sizes.iter().find(|size| size.building_type == building_type)?;
        let slots = spaces.observation.len();
        let [low, high] = size.observation;
        let fits = (low..=high).contains(&slots) && actuators == size.action;
        (!fits).then(|| {
            format!(
                "{} has {slots} slots in its observation and {actuators} actuators, and the problem says {low} to {high} \
                 and {}",
                spaces.building.name, size.action
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_spread_evenly_and_of_every_type() {
        let types = vec![BuildingType::Warehouse, BuildingType::OfficeSmall];
        let buildings = Buildings::Part { types, split: Part::Train };
        let sample = buildings.sample(20);
        assert_eq!(sample.len(), 20);
        assert_eq!(sample.iter().filter(|id| id.building_type() == BuildingType::Warehouse).count(), 10);
        let numbers: Vec<_> = sample[..10].iter().map(|id| id.number()).collect();
        assert!(numbers.is_sorted() && numbers[0] < 100 && numbers[9] > 900, "{numbers:?}");
        assert_eq!(buildings.sample(usize::MAX >> 8).len(), buildings.ids().len());
        assert_eq!(buildings.sample(0), []);
    }
}
