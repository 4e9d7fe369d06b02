//! The rule for setpoints that cross: the cooling setpoint of a zone stays above its heating setpoint.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Sequence, setpoints};

/// The thermostats with two setpoints in a building.
///
/// The engine ends its run when a heating setpoint is above the cooling setpoint. Whatever is commanded, the cooling
/// setpoint in use is at least [`setpoints::LEAST_GAP`] above the heating setpoint in use: the cooling setpoint gives way,
/// unless it alone is stuck.
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

    /// Raises the cooling setpoints of an action that are too close to their heating setpoints, or below. Below a
    /// cooling setpoint that is stuck, it lowers the heating setpoint instead.
    pub(super) fn apply(&self, action: &mut [f64], is_stuck: impl Fn(usize) -> bool) {
        for &[heating, cooling] in &self.pairs {
            match is_stuck(cooling) && !is_stuck(heating) {
                true => action[heating] = action[heating].min(action[cooling] - setpoints::LEAST_GAP),
                false => action[cooling] = setpoints::separate(action[heating], action[cooling]),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cooling_setpoint_gives_way_unless_it_alone_is_stuck() {
        let apart = SetpointsApart { pairs: vec![[0, 1]] };
        let applied = |stuck: &[usize]| {
            let mut action = [21.0, 17.0];
            apart.apply(&mut action, |index| stuck.contains(&index));
            action
        };
        assert_eq!(applied(&[]), [21.0, 21.0 + setpoints::LEAST_GAP]);
        assert_eq!(applied(&[0, 1]), applied(&[]));
        assert_eq!(applied(&[0]), applied(&[]));
        assert_eq!(applied(&[1]), [17.0 - setpoints::LEAST_GAP, 17.0]);
    }
}
