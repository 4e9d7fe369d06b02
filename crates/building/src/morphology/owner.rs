//! Owners of the slots of observations and actions.

use serde::Serialize;

use crate::PreparedBuilding;
use crate::hvac::{Actuator, System};

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
        let owned = |(index, system): (usize, _)| self.actuators_of(index, system);
        self.systems.iter().enumerate().flat_map(owned)
    }

    fn actuators_of<'a>(&self, index: usize, system: &'a System) -> Vec<(Owner, &'a Actuator)> {
        let zone = |name: &str| {
            let number = self.zones.iter().position(|zone| zone.name.eq_ignore_ascii_case(name));
            Owner::Zone(number.expect("a system serves zones of its model"))
        };
        let owner = |actuator: &Actuator| match system {
            System::Unitary(unit) => zone(&unit.zone),
            System::HeatingOnly(heater) => zone(&heater.zone),
            System::AirLoop(air_loop) => {
                let mut terminals = air_loop.terminals.iter();
                let own = terminals.find(|terminal| [&terminal.damper, &terminal.reheat].contains(&actuator));
                own.map_or(Owner::AirLoop(index), |terminal| zone(&terminal.zone))
            }
        };
        system.actuators().into_iter().map(|actuator| (owner(actuator), actuator)).collect()
    }
}
