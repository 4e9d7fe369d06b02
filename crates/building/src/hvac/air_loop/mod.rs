//! Central air loops: supply temperature, outdoor air, dampers, reheat.
//!
//! [`make_controllable`] replaces the controls of a loop of variable-volume terminals with actuators. The
//! controls of the model (supply temperature reset, economizer, minimum flows, dampers under the thermostat) are
//! removed; the equipment and its capacities are kept. In a generated building, [`enlarge_heating_coil`] is called
//! first.
//!
//! 1. The loop runs at every hour (`always_on`).
//! 2. The branch becomes outdoor air → fan → cooling coil → heating coil, so that the heat of the fan is upstream of
//!    the coils that control the supply temperature.
//! 3. Both coils follow one scheduled supply temperature; outdoor air follows an actuator.
//! 4. The damper of every terminal follows its schedule, and its reheat coil holds the zone's heating
//!    setpoint; the cooling setpoint is out of reach, so that the thermostat never opens a damper.
//!
//! With all dampers open the terminals request more than the fan can deliver (they are sized for different peak hours):
//! then all flows are scaled down by the same factor, to [`AirLoop::fan_flow`] in total.
//!
//! **Do not set the dampers before the end of the first warm-up step.** The values of their schedules at the beginning
//! of a run (0 in the model) are the minimum flows of the terminals for the whole run.

mod branch;
mod components;
mod outdoor_air;
pub(super) mod parts;
mod supply_temperature;
mod system;
mod terminal;
mod water_coil;

pub use parts::{AirLoop, Terminal};
pub use supply_temperature::{HIGHEST_SUPPLY_TEMPERATURE, LOWEST_SUPPLY_TEMPERATURE};
pub use terminal::{HIGHEST_HEATING_SETPOINT, REHEAT_OFF};

use super::availability::always_on;
use super::references::Reference;
use super::setpoint_managers::{is_referred_to, remove_setpoint_managers};
use super::ventilation::Ventilation;
use super::zone_equipment::exhaust_flow;
use crate::{Error, Model, Result};
use branch::MainBranch;
use components::FANS;

/// Makes a central air loop controllable and returns its actuators.
///
/// The model must be hard-sized (no `Autosize` in fans, heating coils and terminals). `air_density` (kg/m³) is the
/// engine's standard density at the site, which turns design volume flows into mass flows.
///
/// # Errors
/// [`Error::Unsupported`] naming the object that is not supported; [`Error::MissingObject`] for a dangling reference.
pub fn make_controllable(model: &mut Model, air_loop: &str, air_density: f64) -> Result<AirLoop> {
    let branch = MainBranch::find(model, air_loop)?;
    let terminals = terminal::find(model, air_loop)?;
    let controller = outdoor_air::controller(model, &branch.outdoor_air)?;
    let fan_flow = fan_flow(model, &branch.fan)? * air_density;
    let ventilation = Ventilation::of(model, &controller, air_density)?;

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
        // Heat recovery upstream of the mixer aims at the setpoint of the mixed air.
        supply_temperature::follow_schedule(model, air_loop, "Mixed Air", mixed, &supply_temperature.key);
    }
    let zones: Vec<_> = terminals.iter().map(|served| served.zone.clone()).collect();
    let exhaust_flow = exhaust_flow(model, &zones)? * air_density;
    let outdoor_air = match exhaust_flow > 0.0 {
        true => outdoor_air::schedule(model, air_loop, &controller, fan_flow, air_density)?,
        false => outdoor_air::release(model, air_loop, &controller, fan_flow)?,
    };
    let terminals = terminals
        .into_iter()
        .map(|served| terminal::make_controllable(model, served, air_density))
        .collect::<Result<_>>()?;
    let name = air_loop.to_owned();
    Ok(AirLoop { name, supply_temperature, outdoor_air, fan_flow, exhaust_flow, ventilation, terminals })
}

/// Enlarges the main heating coil of a loop so that it reaches [`HIGHEST_SUPPLY_TEMPERATURE`] in winter, unless it is a
/// water coil. Arguments as in [`make_controllable`].
///
/// # Errors
/// As [`make_controllable`].
pub fn enlarge_heating_coil(model: &mut Model, air_loop: &str, air_density: f64) -> Result<()> {
    let branch = MainBranch::find(model, air_loop)?;
    let fan_flow = fan_flow(model, &branch.fan)? * air_density;
    supply_temperature::enlarge(model, &branch.heating, fan_flow)
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
