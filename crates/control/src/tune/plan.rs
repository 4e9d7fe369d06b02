//! The plan of a tuning run: class, objective, training buildings and run periods.

use b2b_building::{Class, RunPeriod};
use b2b_dataset::{BuildingId, GENERATOR_VERSION, Split};
use b2b_env::Task;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::limits::Limits;
use super::space::{self, Axis};
use crate::{Error, Objective, ReactiveParameters, Result};

/// Incremented when the search changes, so that runs do not resume from evaluations of an earlier search.
const REVISION: u32 = 2;

/// The plan of a tuning run: class, objective, parameters and episodes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TuningPlan {
    /// Class to tune for.
    pub class: Class,
    /// Objective.
    pub objective: Objective,
    /// Energy scale τ_E of the loss, Wh/m² per step; `None` for comfort.
    pub energy_scale: Option<f64>,
    /// Version of the dataset.
    pub dataset: &'static str,
    /// Revision of the search.
    pub revision: u32,
    /// Ids of the training buildings of the search.
    pub buildings: Vec<String>,
    /// Ids of the training buildings of the validation.
    pub validation: Vec<String>,
    /// Run periods of each building.
    pub periods: Vec<RunPeriod>,
    /// Whether the search also runs constant targets, as on central air loops: gains that follow target jumps quickly
    /// can let zones with a shared supply temperature drift between jumps.
    pub constant_targets: bool,
    /// Seed of the buildings and the search.
    pub seed: u64,
    /// Names of the searched parameters.
    pub parameters: Vec<&'static str>,
    /// Values of the sets evaluated before the first proposal. The first is the defaults.
    pub starts: Vec<Vec<f64>>,
}

/// The training buildings of a tuning run.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingBuildings {
    /// For the search.
    pub search: Vec<BuildingId>,
    /// For the validation.
    pub validation: Vec<BuildingId>,
}

impl TuningPlan {
    /// Setpoint modes of the validation. The search uses the last.
    pub const VALIDATION_SETPOINTS: [&str; 2] = ["constant", "occupancy"];

    /// Creates the plan of the comfort objective.
    pub fn comfort(class: Class, buildings: &TrainingBuildings, periods: &[RunPeriod], seed: u64) -> Self {
        let names = |ids: &[BuildingId]| ids.iter().map(ToString::to_string).collect();
        Self {
            class,
            objective: Objective::Comfort,
            energy_scale: None,
            dataset: GENERATOR_VERSION,
            revision: REVISION,
            buildings: names(&buildings.search),
            validation: names(&buildings.validation),
            periods: periods.to_vec(),
            constant_targets: space::has_air_loops(class),
            seed,
            parameters: Vec::new(),
            starts: Vec::new(),
        }
        .starting_from(&[ReactiveParameters::default()])
    }

    /// Creates the plan of the energy objective from the comfort plan, the comfort set and the energy scale τ_E
    /// measured under it. The search starts from the defaults and the comfort set, each unchanged and with less air.
    pub fn energy(self, comfort: &ReactiveParameters, energy_scale: f64) -> Self {
        let default = ReactiveParameters::default();
        let starts =
            [default.clone(), comfort.clone(), space::with_less_air(&default), space::with_less_air(comfort)];
        let plan = Self { objective: Objective::Energy, energy_scale: Some(energy_scale), ..self };
        plan.starting_from(&starts)
    }

    fn starting_from(self, starts: &[ReactiveParameters]) -> Self {
        let axes = self.axes();
        let values = |set: &ReactiveParameters| axes.iter().map(|axis| axis.of(set)).collect();
        Self {
            parameters: axes.iter().map(Axis::name).collect(),
            starts: starts.iter().map(values).collect(),
            ..self
        }
    }

    /// Returns the limits of the search.
    pub(super) fn search_limits(&self) -> Limits {
        if self.constant_targets { Limits::AIR_LOOP_SEARCH } else { Limits::UNITARY }
    }

    /// Returns the limits of an eligible set.
    pub(super) fn limits(&self) -> Limits {
        if self.constant_targets { Limits::AIR_LOOP } else { Limits::UNITARY }
    }

    /// Returns the searched parameters.
    pub(super) fn axes(&self) -> &'static [Axis] {
        space::axes(self.class, self.objective)
    }

    /// Returns the tasks of the validation, without an energy term: actions do not depend on it, and comfort and energy
    /// are summed separately.
    ///
    /// # Errors
    /// [`Error::Env`].
    pub fn tasks() -> Result<Vec<Task>> {
        Ok(Self::VALIDATION_SETPOINTS
            .iter()
            .map(|text| text.parse())
            .collect::<std::result::Result<_, _>>()?)
    }
}

impl TrainingBuildings {
    /// Draws training buildings of a class by a seed. Returns them in the order of their ids.
    ///
    /// # Errors
    /// [`Error::TooFewBuildings`].
    pub fn draw(class: Class, search: usize, validation: usize, seed: u64) -> Result<Self> {
        let rows = b2b_dataset::rows(class.building_type).iter();
        let of_class = rows.filter(|row| row.split == Split::Train && row.building.class() == class);
        let mut left: Vec<BuildingId> = of_class.map(|row| row.id).collect();
        let requested = search + validation;
        if search == 0 || requested > left.len() {
            let class = class.to_string();
            return Err(Error::TooFewBuildings { class, available: left.len(), requested });
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |count: usize| {
            let mut drawn: Vec<_> =
                (0..count).map(|_| left.swap_remove(random.random_range(0..left.len()))).collect();
            drawn.sort_by_key(|id| id.number());
            drawn
        };
        Ok(Self { search: draw(search), validation: draw(validation) })
    }

    /// Returns all buildings: search, then validation.
    pub fn all(&self) -> Vec<BuildingId> {
        self.search.iter().chain(&self.validation).copied().collect()
    }
}
