//! The supply temperature of a central air loop: one schedule for both coils.

use serde_json::json;

use super::branch::MainBranch;
use super::components::{AIR_SPECIFIC_HEAT, WATER_HEATING};
use super::water_coil;
use crate::hvac::actuator::{Actuator, EngineVariable, Quantity};
use crate::hvac::references::Reference;
use crate::hvac::schedules::constant_schedule;
use crate::{Model, Result};

/// Lower bound of the supply temperature, °C, which the cooling coils reach in summer.
pub const LOWEST_SUPPLY_TEMPERATURE: f64 = 10.0;
/// Upper bound of the supply temperature, °C, which the heating coil reaches in winter.
pub const HIGHEST_SUPPLY_TEMPERATURE: f64 = 55.0;
/// Supply temperature before the first action, °C.
pub(super) const NEUTRAL_SUPPLY_TEMPERATURE: f64 = 20.0;
/// Temperature rise of the fan's design flow over the main heating coil, K: room air to the highest supply temperature
/// with 25 % outdoor air at -17 °C. The coils of the prototypes (about 4 K) only temper outdoor air and leave all
/// heating to reheat: they do not reach 25 °C in winter.
pub(super) const HEATING_COIL_RISE: f64 = 45.0;
/// Field of the capacity of a gas or electric coil, W.
const CAPACITY: &str = "nominal_capacity";

/// Enlarges a gas or electric coil to warm the fan's design flow (kg/s) by [`HEATING_COIL_RISE`]. A water coil keeps
/// its size, for which its plant is sized.
pub(super) fn enlarge(model: &mut Model, coil: &Reference, fan_flow: f64) -> Result<()> {
    if coil.class.eq_ignore_ascii_case(WATER_HEATING) {
        return Ok(());
    }
    let enough = HEATING_COIL_RISE * AIR_SPECIFIC_HEAT * fan_flow;
    let shipped = model.require_size(&coil.class, &coil.name, CAPACITY)?;
    model.require_mut(&coil.class, &coil.name)?.insert(CAPACITY.into(), shipped.max(enough).into());
    Ok(())
}

/// Returns the upper bound of the supply temperature, °C: what the coil reaches at the fan's design flow (kg/s) from
/// [`NEUTRAL_SUPPLY_TEMPERATURE`], at most [`HIGHEST_SUPPLY_TEMPERATURE`].
pub(super) fn heating_reach(model: &Model, coil: &Reference, fan_flow: f64) -> Result<f64> {
    let capacity = match coil.class.eq_ignore_ascii_case(WATER_HEATING) {
        true => water_coil::capacity(model, coil)?,
        false => model.require_size(&coil.class, &coil.name, CAPACITY)?,
    };
    let rise = capacity / (AIR_SPECIFIC_HEAT * fan_flow);
    Ok((NEUTRAL_SUPPLY_TEMPERATURE + rise).min(HIGHEST_SUPPLY_TEMPERATURE))
}

/// Schedules one temperature for both coils, at the outlets of the cooling and the heating coil.
pub(super) fn schedule(model: &mut Model, air_loop: &str, branch: &MainBranch, highest: f64) -> Actuator {
    let name = format!("{air_loop} Supply Air Temperature");
    constant_schedule(model, &name, NEUTRAL_SUPPLY_TEMPERATURE);
    follow_schedule(model, air_loop, "Cooling", &branch.cooling_outlet(), &name);
    follow_schedule(model, air_loop, "Heating", branch.outlet(), &name);
    let effect = EngineVariable::new("System Node Temperature", branch.outlet());
    let bounds = [LOWEST_SUPPLY_TEMPERATURE, highest];
    let label = format!("{air_loop} supply air temperature");
    Actuator::of_schedule(name, label, Quantity::SupplyAirTemperature, bounds, effect)
}

pub(super) fn follow_schedule(model: &mut Model, air_loop: &str, place: &str, node: &str, schedule: &str) {
    let fields = json!({
        "control_variable": "Temperature",
        "schedule_name": schedule,
        "setpoint_node_or_nodelist_name": node,
    });
    model.insert("SetpointManager:Scheduled", &format!("{air_loop} {place} Setpoint"), fields);
}
