//! The dataset `v1`: 6,000 buildings, each a function of its id.
//!
//! 1. [`sample()`] draws buildings of a type by Latin hypercube sampling over places and parameters, some of which a
//!    [`Setting`] may fix or narrow; [`rows`] returns the 1,000 buildings of a type in the dataset.
//! 2. A [`Row`] assigns a [`Building`] to a split: 10 % of the buildings of each location (for houses, of each region)
//!    form the test split. Eight of them per type form a small test: one per climate zone from 1 to 8, or for houses
//!    spread over the regions.
//! 3. [`Building::model`] generates the model. Parameters are rounded before use, so that [`manifest()`] has their
//!    exact values.
//!
//! [`Catalog`] finds the model and the weather of a building by its name: a type, an id or a user's model file.
//!
//! Results do not depend on the machine: random numbers are from ChaCha8, and arithmetic is from IEEE 754 and the
//! `libm` crate.

pub mod archetype;
mod building;
mod catalog;
pub mod commercial;
mod control;
mod error;
mod ground_temperatures;
pub mod house;
mod id;
pub mod manifest;
mod preparation;
mod sample;
mod setting;

use std::sync::OnceLock;

pub use building::Building;
pub use catalog::{BuildingName, Catalog, Found, Placement};
pub use control::Control;
pub use error::{Error, Result};
pub use id::{BUILDINGS_PER_TYPE, BuildingId};
pub use manifest::manifest;
pub use preparation::Preparation;
pub use preparation::cache::prepared_folder;
pub use sample::split::Split;
pub use sample::{Places, sample};
pub use setting::Setting;

use b2b_building::BuildingType;

/// Version of the generator; it changes with the buildings.
pub const GENERATOR_VERSION: &str = "v1";

/// A building of the dataset.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its id.
    pub id: BuildingId,
    /// The building.
    pub building: Building,
    /// Its split.
    pub split: Split,
    /// Whether it belongs to the small test.
    pub test_small: bool,
}

impl Row {
    /// Returns whether the building is in an ASHRAE 169 climate zone such as `5B`, or in any with a number such as `5`.
    /// Always `false` for houses, whose regions have no zone.
    pub fn is_in_climate_zone(&self, zone: &str) -> bool {
        let own = self.building.location().ashrae_zone();
        own.is_some_and(|own| own == zone || own.trim_end_matches(char::is_alphabetic) == zone)
    }
}

/// Returns the buildings of a type, by number.
pub fn rows(building_type: BuildingType) -> &'static [Row] {
    static ROWS: [OnceLock<Vec<Row>>; BuildingType::ALL.len()] = [const { OnceLock::new() }; 6];
    ROWS[building_type as usize].get_or_init(|| draw(building_type))
}

/// Returns the building of an id.
pub fn row(id: BuildingId) -> &'static Row {
    &rows(id.building_type())[id.number() as usize - 1]
}

/// Returns every building, by type in the order of [`BuildingType::ALL`].
pub fn all() -> impl Iterator<Item = &'static Row> {
    BuildingType::ALL.into_iter().flat_map(rows)
}

fn draw(building_type: BuildingType) -> Vec<Row> {
    let stream = format!("{GENERATOR_VERSION}/{building_type}");
    let buildings = sample::draw(building_type, &stream, BUILDINGS_PER_TYPE as usize, 0, &Places::All, &[])
        .expect("points of the unit cube at known places make buildings");
    let split = sample::split::split(&buildings, &stream);
    let row = |(building, number)| Row {
        id: BuildingId::new(building_type, number).expect("as many buildings as numbers"),
        split: if split.test[number as usize - 1] { Split::Test } else { Split::Train },
        test_small: split.small[number as usize - 1],
        building,
    };
    buildings.into_iter().zip(1..).map(row).collect()
}

#[cfg(test)]
mod tests;
