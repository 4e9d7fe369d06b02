//! The plan of a tuning run: class, training buildings, periods and task.

use b2b_building::{Class, RunPeriod};
use b2b_dataset::{BuildingId, GENERATOR_VERSION, Split};
use b2b_env::Task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::space;
use crate::{Error, Result};

/// What to tune, and on which episodes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Class to tune for.
    pub class: Class,
    /// Version of the dataset.
    pub dataset: &'static str,
    /// Ids of the training buildings.
    pub buildings: Vec<String>,
    /// Run periods of each building.
    pub periods: Vec<RunPeriod>,
    /// Task, in its short text form.
    pub task: String,
    /// Seed of the buildings and the search.
    pub seed: u64,
    /// Names of the searched parameters.
    pub parameters: Vec<&'static str>,
}

impl Plan {
    /// Creates a plan for a class on these training buildings.
    pub fn new(
        class: Class,
        buildings: &[BuildingId],
        periods: &[RunPeriod],
        task: &Task,
        seed: u64,
    ) -> Self {
        Self {
            class,
            dataset: GENERATOR_VERSION,
            buildings: buildings.iter().map(ToString::to_string).collect(),
            periods: periods.to_vec(),
            task: task.to_string(),
            seed,
            parameters: space::axes(class).iter().map(space::Axis::name).collect(),
        }
    }
}

/// Draws `count` training buildings of a class by a seed. Returns them in the order of their ids.
///
/// # Errors
/// [`Error::TooFewBuildings`].
pub fn training_buildings(class: Class, count: usize, seed: u64) -> Result<Vec<BuildingId>> {
    let rows = b2b_dataset::rows(class.building_type).iter();
    let of_class = rows.filter(|row| row.split == Split::Train && row.building.class() == class);
    let mut left: Vec<BuildingId> = of_class.map(|row| row.id).collect();
    if count == 0 || count > left.len() {
        let class = class.to_string();
        return Err(Error::TooFewBuildings { class, available: left.len(), requested: count });
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn: Vec<_> =
        (0..count).map(|_| left.swap_remove(random.random_range(0..left.len()))).collect();
    drawn.sort_by_key(|id| id.number());
    Ok(drawn)
}
