//! Places of the steps of an environment in the shared memory.

use serde::{Deserialize, Serialize};

use crate::rollout::Widths;

/// How many numbers [`Block::times`] has.
const TIMES: usize = 2;

/// The block of an environment: the observations, actions and rewards of consecutive steps, the observation after the
/// last step, two times, and the state of a recurrent actor before and after a fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    place: usize,
    steps: usize,
    observation: usize,
    action: usize,
    parts: usize,
    state: usize,
}

impl Block {
    /// Returns the block that begins at `place` and has room for `steps` steps, and for a state of this width.
    pub(super) fn new(place: usize, steps: usize, widths: Widths, state: usize) -> Self {
        let Widths { observation, action, parts, .. } = widths;
        Self { place, steps, observation, action, parts, state }
    }

    /// Returns how many numbers it has.
    pub(super) fn numbers(&self) -> usize {
        self.state() + self.state - self.place
    }

    /// Returns the number of parts of a reward.
    pub(super) fn parts(&self) -> usize {
        self.parts
    }

    /// Returns the place of the observation before a step.
    pub(super) fn observation(&self, step: usize) -> usize {
        self.place + step * self.observation
    }

    /// Returns the place of the action of a step.
    pub(super) fn action(&self, step: usize) -> usize {
        self.observation(self.steps) + step * self.action
    }

    /// Returns the place of the parts of the reward of a step.
    pub(super) fn reward(&self, step: usize) -> usize {
        self.action(self.steps) + step * self.parts
    }

    /// Returns the place of the observation after the last step.
    pub(super) fn next(&self) -> usize {
        self.reward(self.steps)
    }

    /// Returns the place of two times: spent on actions, and on the whole fragment, s.
    pub(super) fn times(&self) -> usize {
        self.next() + self.observation
    }

    /// Returns the place of the state of a recurrent actor: before the fragment, and after it.
    pub(super) fn state(&self) -> usize {
        self.times() + TIMES
    }
}
