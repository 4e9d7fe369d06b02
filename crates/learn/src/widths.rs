//! Widths of observations, actions and rewards.

use b2b_agent::Pilot;

use crate::error::{Error, Result};

/// Widths of the arrays of a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Widths {
    /// Width of an observation.
    pub observation: usize,
    /// Width of an action.
    pub action: usize,
    /// Number of parts of a reward.
    pub parts: usize,
    /// Number of nodes of a building; 1 for flat networks.
    pub nodes: usize,
}

impl Widths {
    /// Returns the widths of a pilot's building, with a reward of this number of parts.
    pub fn of(pilot: &Pilot, parts: usize) -> Self {
        let (observation, action) = pilot.widths();
        Self { observation, action, parts, nodes: pilot.graph().map_or(1, |graph| graph.nodes()) }
    }

    /// Returns the larger of each width.
    #[must_use]
    pub fn covering(self, other: Self) -> Self {
        Self {
            observation: self.observation.max(other.observation),
            action: self.action.max(other.action),
            parts: self.parts.max(other.parts),
            nodes: self.nodes.max(other.nodes),
        }
    }

    /// Checks that a building has these widths or, for a graph network, no larger ones.
    ///
    /// # Errors
    /// [`Error::Collect`] when it has others.
    pub(crate) fn check(self, building: &str, widths: Self, is_graph: bool) -> Result<()> {
        if widths == self || (is_graph && self.covering(widths) == self) {
            return Ok(());
        }
        let why = match is_graph {
            false => mismatch(building),
            true => format!("{building} is larger than the training buildings for which there is room"),
        };
        Err(Error::Collect(why.into()))
    }
}

/// Returns the message about a building that does not fit a flat network.
pub(crate) fn mismatch(building: &str) -> String {
    format!(
        "the observation or the actuators of {building} do not match the network; train on one type (houses with the \
         observation `roles` or `features`), or with the preset `graph`"
    )
}
