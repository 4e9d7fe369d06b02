//! Owners of the slots of observations and actions.

use serde::Serialize;

use crate::PreparedBuilding;
use crate::hvac::Actuator;

/// The part of a building that a slot belongs to. Every slot belongs to exactly one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Owner {
    /// Outdoor weather.
    Weather,
    /// The calendar.
    Calendar,
    /// Energy of the step.
    Energy,
    /// A zone, by its number in [`PreparedBuilding::zones`].
    Zone(usize),
    /// The air handler of a central air loop, by its number in [`PreparedBuilding::systems`].
    AirLoop(usize),
}

impl PreparedBuilding {
    /// Returns the actuators in the order of the action, each with its owner.
    pub fn owned_actuators(&self) -> impl Iterator<Item = (Owner, &Actuator)> {
        self.laid_out_systems().enumerate().flat_map(|(number, (system, layout))| {
            let owner = move |actuator: usize| match system.zone_of(actuator) {
                None => Owner::AirLoop(number),
                Some(zone) => Owner::Zone(layout.zones[zone].index),
            };
            system
                .actuators()
                .into_iter()
                .enumerate()
                .map(move |(number, actuator)| (owner(number), actuator))
        })
    }
}
