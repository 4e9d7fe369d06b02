//! Unitary systems: one unit, controlled by air flow and supply air temperature. It serves the zone with its
//! thermostat, and may serve others, whose terminals share its air in proportion to their design flows.
//!
//! Every packaged unit is rewritten as the same kind, which follows both commands exactly: a blow-through
//! `AirLoopHVAC:UnitarySystem` under setpoint control with a variable-volume fan and a two-speed or water cooling coil,
//! feeding a terminal whose minimum flow is the command. The heating coils of a heat pump move downstream of the unitary
//! system unless the unit has an economizer. Capacities, efficiencies, pressures and the curves of coils are the original
//! unit's; a multi-speed coil gets the curves of its highest speed, the fan those of ASHRAE 90.1, and condensers are
//! cooled by air.

mod assemble;
mod commands;
mod cooling_coil;
mod heat_pump;
mod outdoor_air;
pub(super) mod packaged;
mod rewrite;
mod system;
mod unit;

pub use commands::{supply_air_flow_fraction, supply_air_temperature};
pub use packaged::{HeatPump, Packaged};
pub use system::{Follower, Unitary};

use super::actuator::{Actuator, EngineVariable, Quantity};
use super::air_loop_graph::supply_components;
use super::availability::always_on;
use super::thermostat::{OUT_OF_REACH, OUT_OF_REACH_BELOW, own_thermostat};
use crate::Result;
use crate::model::Model;
use commands::{Schedules, follow_flow, follow_supply_temperature};
use outdoor_air::OutdoorAir;
use unit::{Unit, is_unit};

/// Bounds of the supply air temperature, °C. The lower bound is what a cooling coil delivers without freezing; the
/// upper bound is below what gas coils and heat pumps reach at full flow on a design day.
const SUPPLY_TEMPERATURE: (f64, f64) = (10.0, 45.0);

/// Makes the unitary system of an air loop controllable. The model must be hard-sized.
///
/// # Errors
/// [`crate::Error::Unsupported`] naming the object that cannot be rewritten; [`crate::Error::MissingObject`] for a
/// dangling reference.
pub fn make_controllable(model: &mut Model, air_loop: &str, air_density: f64) -> Result<Unitary> {
    assemble::assemble(model, air_loop)?;
    heat_pump::move_coils_in(model, air_loop)?;
    let unit = Unit::find(model, air_loop)?;
    let packaged = Packaged::of(model, &unit, air_density)?;
    let schedules = Schedules::insert(model, &unit.served.zone);
    always_on(model, air_loop)?;
    for served in std::iter::once(&unit.served).chain(&unit.followers) {
        own_thermostat(model, &served.zone, OUT_OF_REACH_BELOW, OUT_OF_REACH)?;
    }
    let nodes = unit.rewrite(model)?;
    follow_supply_temperature(model, &unit, &nodes, &schedules.temperature);
    let follow = |air: &OutdoorAir| {
        air.follow(model, air_loop, [unit.inlet(), &nodes.fan], unit.outlet(), air_density)
    };
    let ventilation = unit.outdoor_air.as_ref().map(follow).transpose()?;
    let terminal = follow_flow(model, &unit.served, &schedules.flow)?;
    let mut followers = Vec::with_capacity(unit.followers.len());
    for follower in &unit.followers {
        let terminal = follow_flow(model, follower, &schedules.flow)?;
        let design_flow = terminal.design_flow * air_density;
        followers.push(Follower { zone: follower.zone.clone(), design_flow });
    }
    let design_flow =
        followers.iter().map(|f| f.design_flow).sum::<f64>() + terminal.design_flow * air_density;
    let whole = if followers.is_empty() { &terminal.outlet } else { unit.outlet() };
    let flow = Actuator {
        high: design_flow,
        scale: 1.0 / design_flow,
        ..Actuator::of_schedule(
            schedules.flow,
            format!("{} supply air flow", unit.served.zone),
            Quantity::SupplyAirFlow,
            [0.0, 0.0],
            EngineVariable::new("System Node Mass Flow Rate", whole),
        )
    };
    let supply_temperature = Actuator::of_schedule(
        schedules.temperature,
        format!("{} supply air temperature", unit.served.zone),
        Quantity::SupplyAirTemperature,
        [SUPPLY_TEMPERATURE.0, SUPPLY_TEMPERATURE.1],
        EngineVariable::new("System Node Temperature", unit.outlet()),
    );
    Ok(Unitary { flow, supply_temperature, ventilation, packaged, zone: unit.served.zone, followers })
}

/// Returns whether an air loop has a unit or the parts of one.
///
/// # Errors
/// [`crate::Error::MissingObject`] for a dangling reference.
pub(super) fn has_unit(model: &Model, air_loop: &str) -> Result<bool> {
    let components = supply_components(model, air_loop)?;
    Ok(components.iter().any(|c| is_unit(&c.class)) || assemble::has_parts(model, air_loop)?)
}

#[cfg(test)]
mod tests;
