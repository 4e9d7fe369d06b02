//! The dataset `v1`: 6,000 buildings, each a function of its id.
//!
//! 1. [`sample()`] draws buildings of a type by a Latin hypercube over place and parameters, some of which a
//!    [`Setting`] may fix or narrow; [`rows`] are the 1,000 of
//!    each type that make the dataset.
//! 2. A [`Row`] says of its [`Building`] whether it is to train or to test on: of every place (houses: region) a tenth
//!    is for tests. Of these, eight a type are a small test, one for each climate zone from 1 to 8.
//! 3. [`Building::model`] makes the model. Parameters are rounded first: what [`manifest`] says is what is built.
//!
//! Nothing here depends on the machine: the random stream is ChaCha8, and the arithmetic is that of IEEE 754 and the
//! `libm` crate.

pub mod archetype;
mod building;
mod catalog;
pub mod commercial;
mod error;
mod ground_temperatures;
pub mod house;
mod hypercube;
mod id;
pub mod manifest;
pub mod random;
mod sample;
mod setting;
mod split;

use std::sync::OnceLock;

pub use building::Building;
pub use catalog::{BuildingName, Catalog, Found, Placement};
pub use error::{Error, Result};
pub use id::{BUILDINGS_PER_TYPE, BuildingId};
pub use manifest::manifest;
pub use sample::{Places, sample};
pub use setting::Setting;
pub use split::Split;

use b2b_building::BuildingType;

/// Version of the generator: other buildings come under another version.
pub const GENERATOR_VERSION: &str = "v1";

/// A building of the dataset.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its id.
    pub id: BuildingId,
    /// What the id stands for.
    pub building: Building,
    /// What it is for.
    pub split: Split,
    /// Whether it is one of the few of the small test.
    pub test_small: bool,
}

/// The buildings of a type, by number.
pub fn rows(building_type: BuildingType) -> &'static [Row] {
    static ROWS: [OnceLock<Vec<Row>>; BuildingType::ALL.len()] = [const { OnceLock::new() }; 6];
    ROWS[building_type as usize].get_or_init(|| draw(building_type))
}

/// The building of an id.
pub fn row(id: BuildingId) -> &'static Row {
    &rows(id.building_type())[id.number() as usize - 1]
}

/// Every building, type by type in the order of [`BuildingType::ALL`].
pub fn all() -> impl Iterator<Item = &'static Row> {
    BuildingType::ALL.into_iter().flat_map(rows)
}

fn draw(building_type: BuildingType) -> Vec<Row> {
    let stream = format!("{GENERATOR_VERSION}/{building_type}");
    let buildings = sample::draw(building_type, &stream, BUILDINGS_PER_TYPE as usize, 0, &Places::All, &[])
        .expect("points of the unit cube at known places make buildings");
    let split = split::split(&buildings, &stream);
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
