//! The paper's reactive controllers, after ASHRAE Guideline 36: PI loops on air flow, trim-and-respond on supply air
//! temperature, and thermostats for heaters.

mod air_loop;
mod parameters;
mod pi;
mod trim_respond;
mod unitary;
mod zone;

use b2b_building::hvac::System;
use b2b_building::{Conditioning, PreparedBuilding};
use b2b_env::{ObservationSpace, Target};

pub use air_loop::AirLoopParameters;
pub use parameters::{Parameter, ReactiveParameters};
pub use pi::Gains;
pub use trim_respond::TrimRespond;
pub use unitary::UnitaryParameters;

use crate::Controller;
use zone::ZoneSlots;

/// The paper's reactive controllers, one per system of a building.
#[derive(Clone, Debug)]
pub struct Reactive {
    systems: Vec<Loop>,
}

/// The controller of one system.
#[derive(Clone, Debug)]
enum Loop {
    Unitary(unitary::Unitary),
    AirLoop(air_loop::AirLoop),
    /// A heater under its own thermostat, whose setpoint is the target.
    Heater(Target),
}

impl Reactive {
    /// Creates controllers that hold every controlled zone of a building at its target in the observation space.
    pub fn new(
        building: &PreparedBuilding,
        space: &ObservationSpace,
        steps_per_hour: u32,
        parameters: &ReactiveParameters,
    ) -> Self {
        let hours = 1.0 / f64::from(steps_per_hour);
        let slots = |name: &str| {
            // A system's zones are zones of its building: preparation took them from there.
            let zone =
                building.zones.iter().position(|z| z.name.eq_ignore_ascii_case(name)).unwrap_or_default();
            let before = building.zones[..zone].iter().filter(|z| z.conditioning != Conditioning::None);
            ZoneSlots { temperature: zone, target: space.target(before.count()) }
        };
        let outdoor = space.outdoor_temperature();
        let control = |system: &System| match system {
            System::Unitary(unit) => {
                Loop::Unitary(unitary::Unitary::new(unit, slots(&unit.zone), hours, &parameters.unitary))
            }
            System::AirLoop(air_loop) => {
                Loop::AirLoop(air_loop::AirLoop::new(air_loop, slots, outdoor, hours, &parameters.air_loop))
            }
            System::HeatingOnly(heater) => Loop::Heater(slots(&heater.zone).target),
        };
        Self { systems: building.systems.iter().map(control).collect() }
    }
}

impl Controller for Reactive {
    fn reset(&mut self) {
        for system in &mut self.systems {
            match system {
                Loop::Unitary(unit) => unit.reset(),
                Loop::AirLoop(air_loop) => air_loop.reset(),
                Loop::Heater(_) => {}
            }
        }
    }

    fn act(&mut self, observation: &[f64], mut action: &mut [f64]) {
        for system in &mut self.systems {
            let width = match system {
                Loop::Unitary(_) => 2,
                Loop::AirLoop(air_loop) => air_loop.width(),
                Loop::Heater(_) => 1,
            };
            let (own, rest) = action.split_at_mut(width);
            match system {
                Loop::Unitary(unit) => unit.act(observation, own),
                Loop::AirLoop(air_loop) => air_loop.act(observation, own),
                Loop::Heater(target) => own[0] = target.of(observation),
            }
            action = rest;
        }
    }
}
