//! The interface of a controller.

use crate::rollout::decisions::Decisions;

/// A controller: maps an observation to an action, as a policy does, and may keep state between steps.
pub trait Controller {
    /// Resets all state at the beginning of an episode.
    fn reset(&mut self);

    /// Begins another episode in the same building. A controller with memory keeps what it has learned about the
    /// building; by default all state is reset.
    fn next_episode(&mut self) {
        self.reset();
    }

    /// Writes the action for an observation. Both in the order and the units of the environment's spaces.
    fn act(&mut self, observation: &[f64], action: &mut [f64]);

    /// Takes the reward of the last action, which a controller with memory may learn from. Ignored by default.
    fn reward(&mut self, _reward: f64) {}

    /// Returns the decisions behind the last action, for records and pages; `None` for a controller that records none.
    /// Their slots stay the same during an episode.
    fn record(&self) -> Option<&Decisions> {
        None
    }
}
