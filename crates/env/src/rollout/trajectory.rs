//! The record of an episode.

use b2b_base::digest::hex;
use sha2::{Digest, Sha256};

use crate::environment::Step;
use crate::spaces::Spaces;

/// The steps of an episode: observations, actions and penalties. Row-major, one row per step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    /// Observations at the ends of the steps.
    pub observations: Vec<f64>,
    /// Actions as applied, within bounds.
    pub actions: Vec<f64>,
    /// Temperature and energy penalty of each step.
    pub penalties: Vec<[f64; 2]>,
}

impl Trajectory {
    /// Creates an empty trajectory with capacity for an episode.
    pub fn for_episode(spaces: &Spaces) -> Self {
        let steps = spaces.episode_steps();
        Self {
            observations: Vec::with_capacity(steps * spaces.observation.len()),
            actions: Vec::with_capacity(steps * spaces.action.len()),
            penalties: Vec::with_capacity(steps),
        }
    }

    /// Appends a step.
    pub fn push(&mut self, step: &Step<'_>) {
        self.observations.extend_from_slice(step.observation);
        self.actions.extend_from_slice(step.action);
        self.penalties.push([step.reward.temperature_penalty, step.reward.energy_penalty]);
    }

    /// The values of one slot of the observation at the end of each step.
    pub fn observed(&self, slot: usize) -> impl Iterator<Item = f64> {
        self.column(&self.observations, slot)
    }

    /// The values of one actuator in each step.
    pub fn acted(&self, actuator: usize) -> impl Iterator<Item = f64> {
        self.column(&self.actions, actuator)
    }

    fn column<'a>(&self, rows: &'a [f64], index: usize) -> impl Iterator<Item = f64> + use<'a> {
        let width = rows.len() / self.len().max(1);
        rows.iter().skip(index).step_by(width.max(1)).copied()
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.penalties.len()
    }

    /// Returns whether there is no step.
    pub fn is_empty(&self) -> bool {
        self.penalties.is_empty()
    }

    /// SHA-256 of all values, in hexadecimal: equal hashes mean equal episodes.
    pub fn hash(&self) -> String {
        let mut hasher = Sha256::new();
        let penalties = self.penalties.iter().flatten();
        for value in self.observations.iter().chain(&self.actions).chain(penalties) {
            hasher.update(value.to_le_bytes());
        }
        hex(&hasher.finalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_one_value_per_step() {
        let trajectory = Trajectory {
            observations: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            actions: vec![7.0, 8.0],
            penalties: vec![[0.0; 2]; 2],
        };
        assert_eq!(trajectory.observed(1).collect::<Vec<_>>(), [2.0, 5.0]);
        assert_eq!(trajectory.acted(0).collect::<Vec<_>>(), [7.0, 8.0]);
        assert_eq!(Trajectory::default().observed(0).count(), 0);
    }
}
