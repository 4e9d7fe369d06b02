//! The interface of an environment.

use std::sync::Arc;

use crate::Result;
use crate::metrics::Metrics;
use crate::reward::{Reward, StepNumbers, to_numbers};
use crate::spaces::Spaces;
use crate::terms::Amounts;

/// An environment: a building whose HVAC is controlled step by step over a run period.
///
/// [`Env`](crate::Env) runs the engine in this process; an `Episode` of `b2b-workers` runs it in its own worker
/// process. Both give the same bits. A wrapper implements the trait around another environment.
pub trait Environment {
    /// The building with its observation and action spaces.
    fn spaces(&self) -> &Arc<Spaces>;

    /// Starts an episode and returns its first observation; an episode in progress ends.
    ///
    /// # Errors
    /// [`Error::Engine`](crate::Error::Engine) with the engine's messages, or, in a worker process,
    /// [`Error::Lost`](crate::Error::Lost).
    fn reset(&mut self) -> Result<&[f64]>;

    /// Applies an action for one zone time step.
    ///
    /// # Errors
    /// [`Error::ActionNotFinite`](crate::Error::ActionNotFinite) and
    /// [`Error::ActionLength`](crate::Error::ActionLength) leave the episode unchanged;
    /// [`Error::NotReset`](crate::Error::NotReset) without an episode in progress; any other error ends the episode.
    fn step(&mut self, action: &[f64]) -> Result<Step<'_>>;

    /// The metrics of the episode once it is truncated; `None` before.
    fn metrics(&self) -> Option<&Metrics>;
}

/// The outcome of a step.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// State at the end of the step.
    pub observation: &'a [f64],
    /// The action as applied, within bounds.
    pub action: &'a [f64],
    /// Reward by its terms.
    pub reward: Reward,
    /// Energy, cost, emissions and the other terms.
    pub terms: Amounts,
    /// Whether the episode is over.
    pub truncated: bool,
}

impl Step<'_> {
    /// Returns reward and terms as numbers.
    pub fn numbers(&self) -> StepNumbers {
        to_numbers(self.reward, &self.terms)
    }
}
