//! What a slot of an observation or an action belongs to.

use serde::Serialize;

use crate::PreparedBuilding;
use crate::hvac::{Actuator, AirLoop, System};

/// The part of a building that a slot belongs to. Every slot belongs to exactly one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Owner {
    /// Outdoor weather.
    Weather,
    /// The clock.
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
            let owner = move |offset: usize| match system {
                System::AirLoop(_) => match AirLoop::terminal(offset) {
                    None => Owner::AirLoop(number),
                    Some(terminal) => Owner::Zone(layout.zones[terminal].index),
                },
                System::Unitary(_) | System::HeatingOnly(_) => Owner::Zone(layout.zones[0].index),
            };
            system
                .actuators()
                .into_iter()
                .enumerate()
                .map(move |(offset, actuator)| (owner(offset), actuator))
        })
    }
}
