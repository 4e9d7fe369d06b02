//! The controlled zones of an environment.

use b2b_building::{Conditioning, PreparedBuilding};

use crate::task::{HeatingOnlyZones, Task};

/// A controlled zone and how a task rewards it.
#[derive(Clone, Copy, Debug)]
pub struct ControlledZone {
    /// Index of the zone in the building, which is also the slot of its air temperature in the observation.
    pub slot: usize,
    /// Whether temperatures above target are penalized.
    pub penalize_above_target: bool,
    /// Whether the zone has both heating and cooling.
    pub fully_conditioned: bool,
}

/// Returns the controlled zones of a building under a task, in model order.
pub(crate) fn controlled_zones(building: &PreparedBuilding, task: &Task) -> Vec<ControlledZone> {
    let both_sides = task.heating_only_zones == HeatingOnlyZones::BothSides;
    building
        .zones
        .iter()
        .enumerate()
        .filter(|(_, zone)| zone.conditioning != Conditioning::None)
        .map(|(slot, zone)| {
            let fully_conditioned = zone.conditioning == Conditioning::HeatingAndCooling;
            let penalize_above_target = fully_conditioned || both_sides;
            ControlledZone { slot, penalize_above_target, fully_conditioned }
        })
        .collect()
}
