//! The paper's reactive controllers, after ASHRAE Guideline 36: PI loops on air flow, trim-and-respond on supply air
//! temperature, and the setpoints of thermostats.

mod air_loop;
mod kind;
mod parameters;
mod pi;
mod setpoints;
mod trim_respond;
mod unitary;
mod zone;

use std::ops::Range;

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Sequence, ServedZone, System, SystemLayout};
use b2b_env::{Controller, Environment, ObservationSpace, Spaces, Target};

pub use air_loop::AirLoopParameters;
pub(crate) use kind::Kind;
pub use parameters::ReactiveParameters;
pub use pi::Gains;
pub use trim_respond::TrimRespond;
pub use unitary::UnitaryParameters;
use zone::ZoneSlots;

/// The paper's reactive controllers, one per system of a building.
#[derive(Clone, Debug)]
pub struct Reactive {
    /// The controllers, each with the range of its system in the action.
    systems: Vec<(Loop, Range<usize>)>,
}

/// The controller of one system.
#[derive(Clone, Debug)]
enum Loop {
    Unitary(unitary::Unitary),
    AirLoop(air_loop::AirLoop),
    /// A thermostat, whose heating setpoint is the target.
    Thermostat(Target),
    Setpoints(setpoints::Setpoints),
}

impl Reactive {
    /// Creates controllers that hold every controlled zone of a building at its target.
    pub fn new(
        building: &PreparedBuilding,
        space: &ObservationSpace,
        steps_per_hour: u32,
        parameters: &ReactiveParameters,
    ) -> Self {
        Self::with_targets(building, space, steps_per_hour, parameters, &|zone| space.target(zone))
    }

    /// Creates controllers that hold every controlled zone at the same target.
    pub(crate) fn at(target: Target, spaces: &Spaces, parameters: &ReactiveParameters) -> Self {
        Self::following(spaces, parameters, &|_| target)
    }

    /// Creates controllers that hold controlled zones, given by number, at these targets, which may be in slots
    /// appended to the environment's.
    pub fn following(
        spaces: &Spaces,
        parameters: &ReactiveParameters,
        target: &dyn Fn(usize) -> Target,
    ) -> Self {
        let (building, space) = (&spaces.building, &spaces.observation);
        Self::with_targets(building, space, spaces.episode.steps_per_hour, parameters, target)
    }

    /// Creates controllers that hold controlled zones, given by number, at these targets.
    fn with_targets(
        building: &PreparedBuilding,
        space: &ObservationSpace,
        steps_per_hour: u32,
        parameters: &ReactiveParameters,
        target: &dyn Fn(usize) -> Target,
    ) -> Self {
        let hours = 1.0 / f64::from(steps_per_hour);
        let slots = |zone: &ServedZone| ZoneSlots {
            temperature: space.zone_temperatures().start + zone.index,
            target: target(zone.controlled),
        };
        let outdoor = space.outdoor_temperature();
        let control = |(system, layout): (&dyn System, &SystemLayout)| {
            let zone = slots(&layout.zones[0]);
            let control = match system.sequence() {
                Sequence::SingleZone { flow, supply_temperature, .. } => Loop::Unitary(
                    unitary::Unitary::new([flow, supply_temperature], zone, hours, &parameters.unitary),
                ),
                Sequence::MultipleZones(air_loop) => {
                    let zones = layout.zones.iter().map(slots);
                    let parameters = &parameters.air_loop;
                    Loop::AirLoop(air_loop::AirLoop::new(air_loop, zones, outdoor, hours, parameters))
                }
                Sequence::Thermostat => Loop::Thermostat(zone.target),
                Sequence::Setpoints { heating, cooling } => {
                    Loop::Setpoints(setpoints::Setpoints::new(heating, cooling, zone.target))
                }
            };
            (control, layout.actions.clone())
        };
        Self { systems: building.laid_out_systems().map(control).collect() }
    }

    /// Records the action that was used instead of the last one of [`act`](Controller::act), for example an agent's
    /// correction. Air loops cool a zone only above the reheat setpoint in use. Otherwise, a zone with a raised
    /// setpoint would be reheated and cooled at once, and its requests would lower the supply air temperature of all
    /// zones.
    pub fn follow(&mut self, used: &[f64]) {
        for (system, range) in &mut self.systems {
            if let Loop::AirLoop(air_loop) = system {
                air_loop.follow(&used[range.clone()]);
            }
        }
    }

    /// Creates controllers for an environment, with the parameters tuned for its class of buildings and the objective
    /// of its task.
    pub fn for_env(environment: &dyn Environment) -> Self {
        let spaces = environment.spaces();
        let parameters = ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task);
        Self::new(&spaces.building, &spaces.observation, spaces.episode.steps_per_hour, &parameters)
    }
}

impl Controller for Reactive {
    fn reset(&mut self) {
        for (system, _) in &mut self.systems {
            match system {
                Loop::Unitary(unit) => unit.reset(),
                Loop::AirLoop(air_loop) => air_loop.reset(),
                Loop::Thermostat(_) | Loop::Setpoints(_) => {}
            }
        }
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        for (system, range) in &mut self.systems {
            let action = &mut action[range.clone()];
            match system {
                Loop::Unitary(unit) => unit.act(observation, action),
                Loop::AirLoop(air_loop) => air_loop.act(observation, action),
                Loop::Thermostat(target) => action[0] = target.of(observation),
                Loop::Setpoints(setpoints) => setpoints.act(observation, action),
            }
        }
    }
}
