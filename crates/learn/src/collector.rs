//! Collectors: sources of rollouts.

use b2b_agent::network::Actor;

use crate::error::{Error, Result};
use crate::rollout::{Rollout, Widths};

/// A set of environments in which an actor collects steps.
pub trait Collector {
    /// Returns the widths of observations, actions and rewards.
    fn widths(&self) -> Widths;

    /// Returns the number of environments.
    fn environments(&self) -> usize;

    /// Collects `steps` steps in every environment with actions sampled from the actor, and overwrites the rollout with
    /// them. Episodes continue where the previous call left off.
    ///
    /// # Errors
    /// When an environment fails.
    fn collect(&mut self, actor: &Actor, steps: usize, rollout: &mut Rollout) -> Result<()>;
}

/// Largest number of consecutive lost episodes of one environment with which the collection goes on.
const LOST_IN_A_ROW: u32 = 5;

/// Counts an episode that was lost.
///
/// # Errors
/// [`Error::LostEpisodes`] when it is one too many in a row.
pub(crate) fn count_lost(in_a_row: &mut u32, why: String) -> Result<()> {
    *in_a_row += 1;
    if *in_a_row > LOST_IN_A_ROW { Err(Error::LostEpisodes { count: *in_a_row, why }) } else { Ok(()) }
}
