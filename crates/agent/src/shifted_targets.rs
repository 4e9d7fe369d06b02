//! The reactive controllers with targets that an agent shifts.

use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_env::{Spaces, Target};

/// The reactive controllers, which follow the shifted target of each controlled zone.
#[derive(Clone, Debug)]
pub struct ShiftedTargets {
    reactive: Reactive,
    /// Largest shift, K.
    shift: f64,
    /// The task's target of each controlled zone.
    targets: Vec<Target>,
    names: Vec<String>,
    /// The environment's observation, then the shifted targets.
    observation: Vec<f64>,
    action: Vec<f64>,
}

impl ShiftedTargets {
    /// Creates the controllers of a building, with the parameters tuned for its class and task.
    pub(crate) fn new(shift: f64, spaces: &Spaces) -> Self {
        let space = &spaces.observation;
        let parameters = ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task);
        let zones: Vec<usize> = spaces.controlled_zones().collect();
        Self {
            reactive: Reactive::following(spaces, &parameters, &|zone| Target::Slot(space.len() + zone)),
            shift,
            targets: (0..zones.len()).map(|zone| space.target(zone)).collect(),
            names: zones.iter().map(|zone| format!("{} target", spaces.building.zones[*zone].name)).collect(),
            observation: vec![0.0; space.len() + zones.len()],
            action: vec![0.0; spaces.action.len()],
        }
    }

    /// Returns the names of the actions.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Begins an episode.
    pub(crate) fn reset(&mut self) {
        self.reactive.reset();
    }

    /// Takes the next observation of the environment.
    pub(crate) fn observe(&mut self, observation: &[f64]) {
        self.observation[..observation.len()].copy_from_slice(observation);
    }

    /// Returns the action of the controllers, in physical units, for an action of the agent in [-1, 1].
    pub(crate) fn act(&mut self, row: &[f32]) -> &[f64] {
        let observed = self.observation.len() - self.targets.len();
        let (observation, shifted) = self.observation.split_at_mut(observed);
        for ((shifted, target), share) in shifted.iter_mut().zip(&self.targets).zip(row) {
            *shifted = target.of(observation) + f64::from(*share) * self.shift;
        }
        self.reactive.act(&self.observation, &mut self.action);
        &self.action
    }
}
