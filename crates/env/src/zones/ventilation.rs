//! The ventilation interlock, which ensures outdoor air for the people in a building regardless of the action.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{System, SystemLayout};
use serde::{Deserialize, Serialize};

/// Outdoor air that a task requires.
///
/// While a zone of a system is occupied, its *design minimum* of outdoor air is required: the minimum flow of the
/// model's outdoor air controller as sized, or the requirement of its zones under mechanical ventilation
/// ([`b2b_building::hvac::Ventilation`]), which follows ASHRAE 62.1 in the prototypes. A zone is occupied if the model
/// had people in it at the end of the previous step, so a system follows within one step (ASHRAE 62.1 averages over
/// short-term conditions). In operation tasks, that takes a tenth of the people at design occupancy
/// ([`b2b_building::people::least_in_use`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ventilation {
    /// An interlock raises commands to the design minimum of outdoor air while a zone of the system is occupied: the
    /// supply flow of a unit, the dampers and the outdoor air of a central air loop. Otherwise, outdoor air may be
    /// zero.
    #[default]
    Code,
    /// No requirement (as in the paper): outdoor air follows the schedules of the model and the commands.
    Free,
}

/// Lower limits of actions while zones are occupied.
#[derive(Debug)]
pub(crate) struct Interlock {
    systems: Vec<Limits>,
}

/// Lower limits of the actions of one system.
#[derive(Debug)]
struct Limits {
    /// Its zones, as indices of controlled zones.
    zones: Vec<usize>,
    /// Indices of actions with their lower limits.
    lower: Vec<(usize, f64)>,
}

impl Interlock {
    /// Returns the interlock of a building.
    pub(crate) fn new(building: &PreparedBuilding) -> Self {
        let limits = building.laid_out_systems().filter_map(|(system, layout)| Limits::of(system, layout));
        Self { systems: limits.collect() }
    }

    /// Raises an action to the limits of the systems with an occupied zone. Returns whether any value changed.
    pub(crate) fn apply(&self, occupied: impl Fn(usize) -> bool, action: &mut [f64]) -> bool {
        let mut acted = false;
        for limits in self.systems.iter().filter(|limits| limits.zones.iter().any(|&zone| occupied(zone))) {
            for &(index, lower) in &limits.lower {
                acted |= action[index] < lower;
                action[index] = action[index].max(lower);
            }
        }
        acted
    }
}

impl Limits {
    fn of(system: &dyn System, layout: &SystemLayout) -> Option<Self> {
        let minimum = system.ventilation()?.min_outdoor_air;
        let limits = system.outdoor_air_limits().into_iter();
        let lower = limits.map(|(actuator, lower)| (layout.actions.start + actuator, lower)).collect();
        let zones = layout.zones.iter().map(|zone| zone.controlled).collect();
        (minimum > 0.0).then_some(Self { zones, lower })
    }
}
