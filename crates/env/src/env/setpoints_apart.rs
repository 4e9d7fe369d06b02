//! The rule for setpoints that cross: the cooling setpoint of a zone stays above its heating setpoint.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Sequence, setpoints};

/// The thermostats with two setpoints in a building.
///
/// The engine ends its run when a heating setpoint is above the cooling setpoint. Whatever is commanded, the cooling
/// setpoint in use is at least [`setpoints::LEAST_GAP`] above the heating setpoint in use.
#[derive(Debug)]
pub(super) struct SetpointsApart {
    /// Indices of the heating and the cooling setpoint of each thermostat.
    pairs: Vec<[usize; 2]>,
}

impl SetpointsApart {
    /// Returns the thermostats with two setpoints in a building.
    pub(super) fn new(building: &PreparedBuilding) -> Self {
        let pair = |first: usize, sequence: Sequence<'_>| match sequence {
            Sequence::Setpoints { cooling: Some(_), .. } => Some([first, first + 1]),
            _ => None,
        };
        let systems = building.laid_out_systems();
        Self {
            pairs: systems
                .filter_map(|(system, layout)| pair(layout.actions.start, system.sequence()))
                .collect(),
        }
    }

    /// Raises the cooling setpoints of an action that are too close to their heating setpoints, or below.
    pub(super) fn apply(&self, action: &mut [f64]) {
        for &[heating, cooling] in &self.pairs {
            action[cooling] = setpoints::separate(action[heating], action[cooling]);
        }
    }
}
