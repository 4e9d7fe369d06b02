//! Tuned parameters of the reactive controllers, shipped as data; `b2b tune` reproduces them.

use std::sync::LazyLock;

use b2b_building::{Class, PreparedBuilding, RunPeriod};
use b2b_env::Task;
use serde::{Deserialize, Serialize};

use crate::{Objective, ReactiveParameters};

/// Parameters tuned for a class and an objective, with their provenance.
///
/// A class has up to two entries, one per [`Objective`]. The task of an episode selects between them:
/// [`ReactiveParameters::tuned`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuned {
    /// Class of buildings.
    pub class: Class,
    /// Objective.
    pub objective: Objective,
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
    /// Ids of the training buildings of the search.
    pub buildings: Vec<String>,
    /// Ids of the training buildings of the validation.
    pub validation: Vec<String>,
    /// Run periods of each building.
    pub periods: Vec<RunPeriod>,
    /// Energy scale τ_E of the loss, Wh/m² per step: the energy measured under the comfort set. `None` for comfort.
    pub energy_scale: Option<f64>,
    /// Command that reproduces the entry.
    pub command: String,
}

/// Measurements of tuned and default parameters on training buildings. A cell is a building under a setpoint mode: the
/// buildings of the search under `occupancy`, with air loops also under `constant`, the buildings of the validation
/// under `constant` and `occupancy`. Losses are the objective's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Loss relative to the default parameters: the median over the cells. 1 is as good as the defaults, 0 is perfect.
    pub relative_loss: f64,
    /// The same in the worst cell.
    pub worst_relative_loss: f64,
    /// Mean loss per step under the default parameters, averaged over the cells.
    pub default_loss: f64,
    /// Mean loss per step under the tuned parameters, averaged over the cells.
    pub loss: f64,
    /// Actuator travel under the default parameters in the worst cell, full strokes/day.
    pub default_daily_travel: f64,
    /// Actuator travel under the tuned parameters in the worst cell, full strokes/day.
    pub daily_travel: f64,
    /// Mean HVAC energy per step under the tuned parameters, averaged over the cells with setpoints by occupancy,
    /// Wh/m². Under the comfort set, this is τ_E of the class.
    pub energy: f64,
}

impl Measured {
    /// All values, in order.
    pub fn values(&self) -> [f64; 7] {
        [
            self.relative_loss,
            self.worst_relative_loss,
            self.default_loss,
            self.loss,
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
    /// Returns all shipped entries.
    pub fn shipped() -> &'static [Self] {
        &SHIPPED
    }

    /// Returns the entry of a class for an objective.
    pub fn of(class: Class, objective: Objective) -> Option<&'static Self> {
        SHIPPED.iter().find(|tuned| tuned.class == class && tuned.objective == objective)
    }
}

impl ReactiveParameters {
    /// Returns the parameters tuned for the class of a building and the objective of a task: see
    /// [`ReactiveParameters::tuned`].
    pub fn tuned_for(building: &PreparedBuilding, task: &Task) -> Self {
        Self::tuned(building.class, building.prototype, Objective::of(task))
    }

    /// Returns the parameters tuned for a class and an objective, or the defaults without an entry and for prototypes,
    /// whose dynamics differ: the kitchen of the restaurant prototype has no thermal mass except its air, and
    /// oscillates under gains that suit the dataset's buildings.
    pub fn tuned(class: Option<Class>, prototype: bool, objective: Objective) -> Self {
        let tuned = class.filter(|_| !prototype).and_then(|class| Tuned::of(class, objective));
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
            assert!(tuned.measured.relative_loss <= 1.0, "{} {}", tuned.class, tuned.objective);
            assert_eq!(tuned.dataset, b2b_dataset::GENERATOR_VERSION);
            assert!(tuned.buildings.iter().all(|id| !tuned.validation.contains(id)), "{}", tuned.class);
            for id in tuned.buildings.iter().chain(&tuned.validation) {
                let row = b2b_dataset::row(id.parse().unwrap());
                assert_eq!((row.split, row.building.class()), (Split::Train, tuned.class), "{id}");
            }
        }
        let entries: BTreeSet<_> =
            Tuned::shipped().iter().map(|tuned| (tuned.class, tuned.objective)).collect();
        assert_eq!(entries.len(), Tuned::shipped().len(), "one entry per class and objective");
    }

    #[test]
    fn the_task_selects_the_set_of_its_objective() {
        for class in Class::all() {
            for objective in Objective::ALL {
                let shipped = Tuned::of(class, objective).map(|tuned| tuned.parameters.clone());
                let expected = shipped.unwrap_or_default();
                assert_eq!(ReactiveParameters::tuned(Some(class), false, objective), expected);
                assert_eq!(
                    ReactiveParameters::tuned(Some(class), true, objective),
                    ReactiveParameters::default()
                );
            }
        }
    }
}
