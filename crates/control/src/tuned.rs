//! What tuning found, shipped as data: `b2b tune` makes it.

use std::sync::LazyLock;

use b2b_building::{Class, PreparedBuilding, RunPeriod};
use serde::{Deserialize, Serialize};

use crate::ReactiveParameters;

/// The parameters that tuning found for a class, and what made them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuned {
    /// For whom.
    pub class: Class,
    /// The parameters.
    pub parameters: ReactiveParameters,
    /// What they come to on the training buildings.
    pub measured: Measured,
    /// How many sets of parameters were tried.
    pub evaluations: usize,
    /// Seed of buildings and search.
    pub seed: u64,
    /// Version of the dataset.
    pub dataset: String,
    /// The training buildings that it was tuned on.
    pub buildings: Vec<String>,
    /// The days that each ran.
    pub periods: Vec<RunPeriod>,
    /// The task, by its spelling.
    pub task: String,
    /// The command that made it.
    pub command: String,
}

/// What parameters come to on training buildings, beside the defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Score of the default parameters: −1, or −1 and a little where a percentile is interpolated.
    pub default_score: f64,
    /// Score of these: the 25th percentile over the buildings of the return in times what the defaults lost. 0 is
    /// perfect.
    pub score: f64,
    /// Penalty of a step under the default parameters, mean over the buildings, K².
    pub default_penalty: f64,
    /// Penalty of a step under these, mean over the buildings, K².
    pub penalty: f64,
    /// Way of an actuator in times its range a day under the default parameters, mean over the buildings.
    pub default_daily_travel: f64,
    /// The same under these.
    pub daily_travel: f64,
    /// HVAC energy of a step under these, mean over the buildings, Wh/m²: τ_E of the class.
    pub energy: f64,
}

impl Measured {
    /// All of them, in order.
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
    /// Every class that was tuned.
    pub fn shipped() -> &'static [Self] {
        &SHIPPED
    }

    /// What was found for a class.
    pub fn of(class: Class) -> Option<&'static Self> {
        SHIPPED.iter().find(|tuned| tuned.class == class)
    }
}

impl ReactiveParameters {
    /// What tuning found for the class of a building: see [`ReactiveParameters::tuned`].
    pub fn tuned_for(building: &PreparedBuilding) -> Self {
        Self::tuned(building.class, building.prototype)
    }

    /// What tuning found for a class; the defaults where there is none, and for prototypes, whose
    /// dynamics are others: the kitchen of the prototype has no mass but its air's, and swings under gains that those of the
    /// dataset take well.
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
    fn shipped_parameters_are_sound_and_no_worse_than_the_defaults_and_saw_no_test_building() {
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
        assert_eq!(classes.len(), Tuned::shipped().len(), "one entry a class");
    }
}
