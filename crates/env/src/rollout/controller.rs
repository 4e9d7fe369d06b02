//! The interface of a controller.

use crate::rollout::decisions::Decisions;

/// A controller: maps an observation to an action, as a policy does, and may keep state between steps.
pub trait Controller {
    /// Resets all state at the beginning of an episode.
    fn reset(&mut self);

    /// Writes the action for an observation. Both in the order and the units of the environment's spaces.
    fn act(&mut self, observation: &[f64], action: &mut [f64]);

    /// Returns the decisions behind the last action, for records and pages; `None` for a controller that records none.
    /// Their slots stay the same during an episode.
    fn record(&self) -> Option<&Decisions> {
        None
    }
}
