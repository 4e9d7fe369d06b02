//! One side of a problem: buildings, tasks and actuators.

use b2b_building::{BuildingType, Period};
use b2b_dataset::BuildingId;
use b2b_dataset::BuildingName;
use b2b_env::Spaces;
use b2b_env::Task;
use serde::{Deserialize, Serialize};

use super::as_text;
use super::buildings::Buildings;
use super::restriction::Restriction;
use crate::{EpisodePlan, Subject};

/// One side of a problem: training or test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Side {
    /// The buildings.
    pub buildings: Buildings,
    /// The tasks; each is run in every building.
    #[serde(with = "as_text::list")]
    pub tasks: Vec<Task>,
    /// Restriction of the action space, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restriction: Option<Restriction>,
    /// Sizes of the spaces by building type, checked when a building is run; empty if unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sizes: Vec<Size>,
}

/// The sizes of a building type's spaces, as in the paper's tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Size {
    /// The building type.
    #[serde(rename = "type", with = "as_text")]
    pub building_type: BuildingType,
    /// Minimum and maximum length of an observation: it depends on attics and garages of houses, and on whether targets
    /// change.
    pub observation: [usize; 2],
    /// Number of actuators without the withheld ones.
    pub action: usize,
}

impl Side {
    /// Returns the episodes of some buildings, ordered by building, run period, task and seed.
    pub fn episodes(
        &self,
        buildings: &[BuildingId],
        windows: &[Period],
        seeds: &[u64],
        steps_per_hour: u32,
    ) -> Vec<EpisodePlan> {
        let subjects: Vec<_> = buildings.iter().map(|id| Subject::at_home(BuildingName::Id(*id))).collect();
        EpisodePlan::combinations(&subjects, windows, &self.tasks, seeds, steps_per_hour)
    }

    /// Describes how the sizes of a building differ from those declared, if they do.
    pub fn size_mismatch(
        &self,
        building_type: BuildingType,
        spaces: &Spaces,
        actuators: usize,
    ) -> Option<String> {
        let size = self.sizes.iter().find(|size| size.building_type == building_type)?;
        let slots = spaces.observation.len();
        let [low, high] = size.observation;
        let matches = (low..=high).contains(&slots) && actuators == size.action;
        (!matches).then(|| {
            format!(
                "{} has {slots} observations and {actuators} actuators; the problem expects {low} to {high} and {}",
                spaces.building.name, size.action
            )
        })
    }
}
