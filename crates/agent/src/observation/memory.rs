//! The state that an agent's observation keeps during an episode.

use b2b_env::{Spaces, Target};

/// Time constant of the recent mean of an error, h.
const RECENT: f64 = 1.0;

/// Observations and errors of previous steps.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    /// Slot of the temperature of each controlled zone, and its target.
    zones: Vec<(usize, Target)>,
    /// Share of the last error in the recent mean.
    share: f64,
    last: Vec<f64>,
    change: Vec<f64>,
    errors: Vec<f64>,
    recent: Vec<f64>,
    is_new: bool,
}

impl Memory {
    pub(super) fn new(spaces: &Spaces) -> Self {
        let space = &spaces.observation;
        let controlled = spaces.controlled_zones().enumerate();
        let zones: Vec<_> = controlled.map(|(index, slot)| (slot, space.target(index))).collect();
        let steps = RECENT * f64::from(spaces.episode.steps_per_hour);
        Self {
            share: 1.0 / steps.max(1.0),
            last: vec![0.0; space.len()],
            change: vec![0.0; space.len()],
            errors: vec![0.0; zones.len()],
            recent: vec![0.0; zones.len()],
            zones,
            is_new: true,
        }
    }

    pub(super) fn reset(&mut self) {
        self.is_new = true;
        self.recent.fill(0.0);
    }

    /// Adds an observation. At the first of an episode, all changes are 0.
    pub(super) fn remember(&mut self, observation: &[f64]) {
        if std::mem::take(&mut self.is_new) {
            self.last.copy_from_slice(observation);
        }
        for ((change, last), now) in self.change.iter_mut().zip(&mut self.last).zip(observation) {
            *change = now - *last;
            *last = *now;
        }
        for (index, (slot, target)) in self.zones.iter().enumerate() {
            let error = observation[*slot] - target.of(observation);
            self.errors[index] = error;
            self.recent[index] += self.share * (error.clamp(-LARGEST, LARGEST) - self.recent[index]);
        }
    }

    /// Change of a slot in the last step.
    pub(super) fn change(&self, slot: usize) -> f64 {
        self.change[slot]
    }

    /// Temperature minus target of a controlled zone, K.
    pub(super) fn error(&self, zone: usize) -> f64 {
        self.errors[zone]
    }

    /// Exponential mean of the error over about an hour, K.
    pub(super) fn recent_error(&self, zone: usize) -> f64 {
        self.recent[zone]
    }
}

/// Limit of the errors in the recent mean, K, because a setback of the target is not an offset to correct.
const LARGEST: f64 = 1.0;
