//! Collectors: sources of rollouts.

use b2b_agent::network::Actor;

use crate::error::{Error, Result};
use crate::rollout::Rollout;

/// Widths of the arrays of a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Widths {
    /// Width of an observation.
    pub observation: usize,
    /// Width of an action.
    pub action: usize,
    /// Number of parts of a reward.
    pub parts: usize,
}

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

impl Widths {
    /// Returns the larger of each width.
    #[must_use]
    pub fn covering(self, other: Self) -> Self {
        Self {
            observation: self.observation.max(other.observation),
            action: self.action.max(other.action),
            parts: self.parts.max(other.parts),
        }
    }

    /// Checks that a building has these widths, or for a graph network at most these.
    ///
    /// # Errors
    /// [`Error::Collect`] when it has others.
    pub(crate) fn check(self, building: &str, widths: (usize, usize), is_graph: bool) -> Result<()> {
        let fits = (widths.0 <= self.observation, widths.1 <= self.action) == (true, true);
        if widths == (self.observation, self.action) || (is_graph && fits) {
            return Ok(());
        }
        let why = match is_graph {
            false => format!("the observation or the actuators of {building} do not match the network"),
            true => format!("{building} is larger than the training buildings for which there is room"),
        };
        Err(Error::Collect(why.into()))
    }
}

/// Number of consecutive lost episodes of one environment after which the collection fails.
const LOST_IN_A_ROW: u32 = 5;

/// Counts an episode that was lost.
///
/// # Errors
/// [`Error::LostEpisodes`] when it is one too many in a row.
pub(crate) fn count_lost(in_a_row: &mut u32, why: String) -> Result<()> {
    *in_a_row += 1;
    if *in_a_row > LOST_IN_A_ROW { Err(Error::LostEpisodes { count: *in_a_row, why }) } else { Ok(()) }
}
