//! Terminals of a central air loop: dampers and reheat.

use super::components::{AIR_SPECIFIC_HEAT, HEATING, WATER_HEATING};
use super::system::Terminal;
use super::water_coil;
use crate::hvac::actuator::{Actuator, EngineVariable, Quantity};
use crate::hvac::availability::switch_on;
use crate::hvac::distribution::{ServedZone, served_zones};
use crate::hvac::references::{Reference, is_one_of};
use crate::hvac::schedules::constant_schedule;
use crate::hvac::thermostat::{OUT_OF_REACH, own_thermostat};
use crate::model::text;
use crate::{Error, Model, Result};

/// Heating setpoint at which reheat is off, °C: no zone gets so cold.
pub const REHEAT_OFF: f64 = 10.0;
/// Upper bound of the heating setpoint, °C.
pub const HIGHEST_HEATING_SETPOINT: f64 = 30.0;
/// Temperature rise over a reheat coil above which more air brings more heat, K.
const REHEAT_RISE: f64 = 15.0;
pub(super) const TERMINAL: &str = "AirTerminal:SingleDuct:VAV:Reheat";

/// Returns the terminals of an air loop, each with its zone, in model order of the zones.
pub(super) fn find(model: &Model, air_loop: &str) -> Result<Vec<(String, String)>> {
    let mut terminals = Vec::new();
    for ServedZone { zone, terminal, .. } in served_zones(model, air_loop)? {
        if !terminal.class.eq_ignore_ascii_case(TERMINAL) {
            let why = format!("unsupported terminal; expected {TERMINAL}");
            return Err(Error::unsupported(&terminal.class, &terminal.name, &why));
        }
        require_reheat(model, &terminal.name)?;
        terminals.push((zone, terminal.name));
    }
    Ok(terminals)
}

fn require_reheat(model: &Model, terminal: &str) -> Result<()> {
    let coil = text(model.require(TERMINAL, terminal)?, "reheat_coil_object_type").unwrap_or_default();
    if is_one_of(coil, &HEATING) {
        return Ok(());
    }
    Err(Error::unsupported(
        TERMINAL,
        terminal,
        &format!("unsupported reheat coil; expected {}", HEATING.join(" or ")),
    ))
}

/// Makes the damper of a terminal follow a schedule and its reheat coil the zone's own heating setpoint.
pub(super) fn make_controllable(
    model: &mut Model,
    zone: String,
    terminal: &str,
    air_density: f64,
) -> Result<Terminal> {
    switch_on(model, &Reference { class: TERMINAL.into(), name: terminal.into() })?;
    let design_flow = model.require_size(TERMINAL, terminal, "maximum_air_flow_rate")? * air_density;
    let opening = schedule_damper(model, &zone, terminal)?;
    let setpoints = own_thermostat(model, &zone, REHEAT_OFF, OUT_OF_REACH)?;
    let fields = model.require(TERMINAL, terminal)?;
    let inlet = text(fields, "air_inlet_node_name").unwrap_or_default();
    let coil = text(fields, "reheat_coil_name").unwrap_or_default();
    let class = text(fields, "reheat_coil_object_type").unwrap_or_default();
    let heating_opening = match class.eq_ignore_ascii_case(WATER_HEATING) {
        true => {
            let coil = Reference { class: class.to_owned(), name: coil.to_owned() };
            let flow = water_coil::capacity(model, &coil)? / (AIR_SPECIFIC_HEAT * REHEAT_RISE);
            (flow / design_flow).clamp(0.0, 1.0)
        }
        false => 1.0,
    };
    let effect = EngineVariable::new("System Node Mass Flow Rate", inlet);
    let label = format!("{zone} damper opening");
    let damper = Actuator::of_schedule(opening, label, Quantity::DamperOpening, [0.0, 1.0], effect);
    let damper = Actuator { effect_scale: design_flow, ..damper };
    let bounds = [REHEAT_OFF, HIGHEST_HEATING_SETPOINT];
    let effect = EngineVariable::new("Zone Thermostat Heating Setpoint Temperature", &zone);
    let label = format!("{zone} heating setpoint");
    let reheat = Actuator::of_schedule(setpoints.heating, label, Quantity::HeatingSetpoint, bounds, effect);
    let reheat = Actuator { heat: Some(EngineVariable::new("Heating Coil Heating Rate", coil)), ..reheat };
    Ok(Terminal { zone, damper, reheat, design_flow, heating_opening })
}

/// Schedules the minimum flow of a terminal. With the cooling setpoint out of reach and a damper that does not reverse for
/// heating, a terminal always has its minimum flow. The schedule is 0 because its value at the beginning of a run is a
/// lower limit for the whole run.
fn schedule_damper(model: &mut Model, zone: &str, terminal: &str) -> Result<String> {
    let name = format!("{zone} Damper Opening");
    constant_schedule(model, &name, 0.0);
    let fields = model.require_mut(TERMINAL, terminal)?;
    fields.retain(|field, _| {
        !field.contains("minimum_air_flow")
            && !field.starts_with("maximum_flow_")
            && !field.contains("turndown")
    });
    fields.insert("zone_minimum_air_flow_input_method".into(), "Scheduled".into());
    fields.insert("minimum_air_flow_fraction_schedule_name".into(), name.clone().into());
    fields.insert("damper_heating_action".into(), "Normal".into());
    Ok(name)
}
