//! Central air loops: supply temperature, outdoor air, dampers, reheat.
//!
//! [`make_controllable`] turns an air loop with variable-volume reheat terminals into one that does what an
//! agent says. What the shipped controls decide (supply temperature reset, economizer, minimum flows,
//! dampers under the thermostat) goes; the equipment and its capacities stay, but for the main heating coil.
//!
//! 1. The loop runs at every hour ([`always_on`]).
//! 2. The branch becomes outdoor air → fan → cooling coil → heating coil, so that the fan's heat is ahead of
//!    the coils that answer for the supply temperature.
//! 3. Both coils follow one scheduled supply temperature; outdoor air follows an actuator.
//! 4. Every terminal's damper stands where its schedule says, and its reheat coil holds the zone's heating
//!    setpoint; the cooling setpoint is out of reach, so that the thermostat never opens a damper.
//!
//! All dampers open ask for more than the fan gives (the boxes peak at different hours): then the flows of
//! all terminals scale down by the same share, to [`AirLoop::fan_flow`] in sum.
//!
//! **Leave the dampers alone until the first warm-up step is over.** What their schedules hold when the engine
//! begins a run (0 in the model) stays the least flow of the terminals for the whole run.

mod branch;
mod components;
mod outdoor_air;
mod supply_temperature;
mod terminal;
mod water_coil;

pub use supply_temperature::{HIGHEST_SUPPLY_TEMPERATURE, LOWEST_SUPPLY_TEMPERATURE};
pub use terminal::{HIGHEST_HEATING_SETPOINT, REHEAT_OFF};

use super::availability::always_on;
use super::references::Reference;
use super::setpoint_managers::{is_referred_to, remove_setpoint_managers};
use super::system::AirLoop;
use crate::{Error, Model, Result};
use branch::MainBranch;
use components::FANS;

/// Makes a central air loop do what an agent says, and lists its actuators.
///
/// The model must carry its sizes (no `Autosize` in the fan and the terminals). `air_density` (kg/m³) is the
/// engine's standard density at the site, which turns design volume flows into mass flows.
///
/// # Errors
/// [`Error::Unsupported`] naming the object that these edits do not know; [`Error::MissingObject`] when the
/// model refers to something that is not there.
pub fn make_controllable(model: &mut Model, air_loop: &str, air_density: f64) -> Result<AirLoop> {
    let branch = MainBranch::find(model, air_loop)?;
    let terminals = terminal::find(model, air_loop)?;
    let controller = outdoor_air::controller(model, &branch.outdoor_air)?;
    let fan_flow = fan_flow(model, &branch.fan)? * air_density;

    always_on(model, air_loop)?;
    remove_setpoint_managers(model, &branch.nodes());
    branch.rewire(model)?;
    for coil in branch.blow_through() {
        water_coil::follow_outlet(model, &coil.object, &coil.outlet)?;
    }
    let highest = supply_temperature::heating_reach(model, &branch.heating, fan_flow)?;
    let supply_temperature = supply_temperature::schedule(model, air_loop, &branch, highest);
    let mixed = &branch.components[0].outlet;
    if is_referred_to(model, mixed) {
        // Heat recovery ahead of the mixer aims at what the mixed air should be.
        supply_temperature::follow_schedule(model, air_loop, "Mixed Air", mixed, &supply_temperature.key);
    }
    let zones: Vec<_> = terminals.iter().map(|(zone, _)| zone.clone()).collect();
    let exhaust_flow = outdoor_air::exhaust_flow(model, &zones)? * air_density;
    let outdoor_air = match exhaust_flow > 0.0 {
        true => outdoor_air::schedule(model, air_loop, &controller, fan_flow, air_density)?,
        false => outdoor_air::release(model, air_loop, &controller, fan_flow)?,
    };
    let terminals = terminals
        .into_iter()
        .map(|(zone, terminal)| terminal::make_controllable(model, zone, &terminal, air_density))
        .collect::<Result<_>>()?;
    let name = air_loop.to_owned();
    Ok(AirLoop { name, supply_temperature, outdoor_air, fan_flow, exhaust_flow, terminals })
}

/// Design flow of a fan, m³/s.
fn fan_flow(model: &Model, fan: &Reference) -> Result<f64> {
    let field = FANS.iter().find(|(class, _)| class.eq_ignore_ascii_case(&fan.class)).map(|(_, field)| field);
    let field =
        field.ok_or_else(|| Error::unsupported(&fan.class, &fan.name, "it is not a variable-flow fan"))?;
    model.require_size(&fan.class, &fan.name, field)
}

#[cfg(test)]
mod tests;
