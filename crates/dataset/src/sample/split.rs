//! Splits of the dataset.

use std::fmt;

use b2b_climate::{Location, Place, Region};

use super::hypercube::permutation;
use crate::Building;

/// One in `TEST_SHARE` buildings belongs to the test split.
const TEST_SHARE: usize = 10;
/// Buildings of the small test.
const SMALL: usize = 8;

/// The split of a building.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Split {
    /// For training.
    Train,
    /// For tests.
    Test,
}

impl fmt::Display for Split {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Train => "train",
            Self::Test => "test",
        })
    }
}

/// Membership in the test split and in the small test.
pub(crate) struct Selection {
    pub(crate) test: Vec<bool>,
    pub(crate) small: Vec<bool>,
}

/// Assigns every tenth building to the test split, in an order sorted by place and random within a place: 10 % of the
/// buildings of each place, to within one.
pub(crate) fn split(buildings: &[Building], stream: &str) -> Selection {
    let mut order = permutation(stream, 0, buildings.len());
    order.sort_by_key(|&index| rank(&buildings[index]));
    let test: Vec<usize> = order.into_iter().skip(TEST_SHARE / 2).step_by(TEST_SHARE).collect();
    let small = match buildings.first() {
        Some(Building::Commercial { .. }) => one_of_each_zone(buildings, &test),
        _ => evenly(&test),
    };
    Selection { test: flags(buildings.len(), &test), small: flags(buildings.len(), &small) }
}

/// The number of the place or region in its list.
fn rank(building: &Building) -> Option<usize> {
    match building.location() {
        Location::Place(place) => Place::benchmark().iter().position(|each| each == *place),
        Location::Region(region) => Region::all().iter().position(|each| each == *region),
        Location::File(_) => None,
    }
}

/// The first test building of each climate zone from 1 to 8.
fn one_of_each_zone(buildings: &[Building], test: &[usize]) -> Vec<usize> {
    let zone = |index: usize| buildings[index].location().ashrae_zone().and_then(|zone| zone.chars().next());
    ('1'..='8').filter_map(|digit| test.iter().copied().find(|&index| zone(index) == Some(digit))).collect()
}

/// For houses: the middle building of each eighth, spread over the regions.
fn evenly(test: &[usize]) -> Vec<usize> {
    (0..SMALL).filter_map(|k| test.get((2 * k + 1) * test.len() / (2 * SMALL)).copied()).collect()
}

fn flags(count: usize, chosen: &[usize]) -> Vec<bool> {
    let mut flags = vec![false; count];
    chosen.iter().for_each(|&index| flags[index] = true);
    flags
}
