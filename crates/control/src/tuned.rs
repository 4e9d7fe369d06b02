//! Tuned parameters of the reactive controllers, shipped as data; `b2b tune` reproduces them.

use std::sync::LazyLock;

use b2b_building::{Class, PreparedBuilding, RunPeriod};
use serde::{Deserialize, Serialize};

use crate::ReactiveParameters;

/// Tuned parameters of a class, with their provenance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuned {
    /// Class of buildings.
    pub class: Class,
    /// The parameters.
    pub parameters: ReactiveParameters,
    /// Measurements on the training buildings.
    pub measured: Measured,
    /// Number of evaluated sets of parameters.
    pub evaluations: usize,
    /// Seed of the buildings and the search.
    pub seed: u64,
    /// Version of the dataset.
    pub dataset: String,
    /// Ids of the training buildings.
    pub buildings: Vec<String>,
    /// Run periods of each building.
    pub periods: Vec<RunPeriod>,
    /// Task, in its short text form.
    pub task: String,
    /// Command that reproduces the entry.
    pub command: String,
}

/// Measurements of tuned and default parameters on training buildings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Score of the default parameters: −1, up to rounding where the percentile is interpolated.
    pub default_score: f64,
    /// Score of the tuned parameters: the 25th percentile over the buildings of the return relative to the loss of the
    /// defaults. 0 is perfect.
    pub score: f64,
    /// Mean penalty per step under the default parameters, averaged over the buildings, K².
    pub default_penalty: f64,
    /// Mean penalty per step under the tuned parameters, averaged over the buildings, K².
    pub penalty: f64,
    /// Actuator travel under the default parameters, averaged over the buildings, full strokes/day.
    pub default_daily_travel: f64,
    /// Actuator travel under the tuned parameters, averaged over the buildings, full strokes/day.
    pub daily_travel: f64,
    /// Mean HVAC energy per step under the tuned parameters, averaged over the buildings, Wh/m²: τ_E of the class.
    pub energy: f64,
}

impl Measured {
    /// All values, in order.
    pub fn values(&self) -> [f64; 7] {
        [
            self.default_score,
            self.score,
            self.default_penalty,
            self.penalty,
            self.default_daily_travel,
            self.daily_travel,
            self.energy,
        ]
    }
}

static SHIPPED: LazyLock<Vec<Tuned>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../data/tuned.json")).expect("a test reads the shipped file")
});

impl Tuned {
    /// Returns the entries of all tuned classes.
    pub fn shipped() -> &'static [Self] {
        &SHIPPED
    }

    /// Returns the entry of a class.
    pub fn of(class: Class) -> Option<&'static Self> {
        SHIPPED.iter().find(|tuned| tuned.class == class)
    }
}

impl ReactiveParameters {
    /// Returns the parameters tuned for the class of a building: see [`ReactiveParameters::tuned`].
    pub fn tuned_for(building: &PreparedBuilding) -> Self {
        Self::tuned(building.class, building.prototype)
    }

    /// Returns the parameters tuned for a class, or the defaults for a class without an entry and for prototypes, whose
    /// dynamics differ: the kitchen of the restaurant prototype has no thermal mass but its air, and oscillates under gains
    /// that suit the buildings of the dataset.
    pub fn tuned(class: Option<Class>, prototype: bool) -> Self {
        let tuned = class.filter(|_| !prototype).and_then(Tuned::of);
        tuned.map(|tuned| tuned.parameters.clone()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use b2b_dataset::Split;

    use super::*;

    #[test]
    fn shipped_parameters_are_valid_and_no_worse_than_the_defaults_on_training_buildings() {
        for tuned in Tuned::shipped() {
            tuned.parameters.check().unwrap();
            assert!(tuned.measured.score >= tuned.measured.default_score, "{}", tuned.class);
            assert_eq!(tuned.dataset, b2b_dataset::GENERATOR_VERSION);
            for id in &tuned.buildings {
                let row = b2b_dataset::row(id.parse().unwrap());
                assert_eq!((row.split, row.building.class()), (Split::Train, tuned.class), "{id}");
            }
        }
        let classes: BTreeSet<_> = Tuned::shipped().iter().map(|tuned| tuned.class).collect();
        assert_eq!(classes.len(), Tuned::shipped().len(), "one entry per class");
    }
}
