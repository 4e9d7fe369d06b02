//! Terminals of a central air loop: dampers and, where they have coils, reheat.

use super::components::{AIR_SPECIFIC_HEAT, HEATING, WATER_HEATING};
use super::parts::Terminal;
use super::water_coil;
use crate::hvac::actuator::{Actuator, EngineVariable, Quantity};
use crate::hvac::availability::switch_on;
use crate::hvac::distribution::{ServedZone, served_zones};
use crate::hvac::heating_only;
use crate::hvac::references::{Reference, is_one_of, reference};
use crate::hvac::schedules::constant_schedule;
use crate::hvac::thermostat::{OUT_OF_REACH, own_thermostat};
use crate::hvac::zone_equipment::{HEATERS, put_first, zone_equipment};
use crate::model::text;
use crate::{Error, Model, Result};

/// Heating setpoint at which reheat is off, °C: no zone gets so cold.
pub const REHEAT_OFF: f64 = 10.0;
/// Upper bound of the heating setpoint, °C.
pub const HIGHEST_HEATING_SETPOINT: f64 = 30.0;
/// Temperature rise over a reheat coil above which more air brings more heat, K.
const REHEAT_RISE: f64 = 15.0;
pub(super) const REHEAT: &str = "AirTerminal:SingleDuct:VAV:Reheat";
pub(super) const NO_REHEAT: &str = "AirTerminal:SingleDuct:VAV:NoReheat";

/// Returns the terminals of an air loop, each with its zone, in model order of the zones.
pub(super) fn find(model: &Model, air_loop: &str) -> Result<Vec<ServedZone>> {
    let served = served_zones(model, air_loop)?;
    for ServedZone { terminal, .. } in &served {
        if !is_one_of(&terminal.class, &[REHEAT, NO_REHEAT]) {
            let why = format!("unsupported terminal; expected {REHEAT} or {NO_REHEAT}");
            return Err(Error::unsupported(&terminal.class, &terminal.name, &why));
        }
        if let Some(coil) = coil(model, terminal)?
            && !is_one_of(&coil.class, &HEATING)
        {
            let why = format!("unsupported reheat coil; expected {}", HEATING.join(" or "));
            return Err(Error::unsupported(&terminal.class, &terminal.name, &why));
        }
    }
    Ok(served)
}

/// Returns the reheat coil of a terminal.
fn coil(model: &Model, terminal: &Reference) -> Result<Option<Reference>> {
    let fields = model.require(&terminal.class, &terminal.name)?;
    Ok(reference(fields, "reheat_coil_object_type", "reheat_coil_name"))
}

/// Makes the damper of a terminal follow a schedule, and its reheat coil, or else the heater of the zone, follow the
/// zone's own heating setpoint.
pub(super) fn make_controllable(model: &mut Model, served: ServedZone, air_density: f64) -> Result<Terminal> {
    let ServedZone { zone, unit, ref terminal } = served;
    put_first(model, &zone, &unit)?;
    switch_on(model, terminal)?;
    let Reference { class, name } = terminal;
    let design_flow = model.require_size(class, name, "maximum_air_flow_rate")? * air_density;
    let opening = schedule_damper(model, &zone, terminal)?;
    let setpoints = own_thermostat(model, &zone, REHEAT_OFF, OUT_OF_REACH)?;
    let coil = coil(model, terminal)?;
    let heating_opening = match &coil {
        Some(coil) if coil.class.eq_ignore_ascii_case(WATER_HEATING) => {
            let flow = water_coil::capacity(model, coil)? / (AIR_SPECIFIC_HEAT * REHEAT_RISE);
            (flow / design_flow).clamp(0.0, 1.0)
        }
        _ => 1.0,
    };
    let inlet = text(model.require(class, name)?, "air_inlet_node_name").unwrap_or_default();
    let effect = EngineVariable::new("System Node Mass Flow Rate", inlet);
    let label = format!("{zone} damper opening");
    let damper = Actuator::of_schedule(opening, label, Quantity::DamperOpening, [0.0, 1.0], effect);
    let damper = Actuator { effect_scale: design_flow, ..damper };
    let heat = match coil {
        Some(coil) => Some(EngineVariable::new("Heating Coil Heating Rate", &coil.name)),
        None => heat_of_heater(model, &zone)?,
    };
    let reheat = heat.map(|heat| {
        let bounds = [REHEAT_OFF, HIGHEST_HEATING_SETPOINT];
        let effect = EngineVariable::new("Zone Thermostat Heating Setpoint Temperature", &zone);
        let label = format!("{zone} heating setpoint");
        let reheat =
            Actuator::of_schedule(setpoints.heating, label, Quantity::HeatingSetpoint, bounds, effect);
        Actuator { heat: Some(heat), ..reheat }
    });
    Ok(Terminal { zone, damper, reheat, design_flow, heating_opening })
}

/// Switches on the heater of a zone whose terminal has no coil, and returns the engine variable of its heat. Heaters
/// without capacity are left alone.
fn heat_of_heater(model: &mut Model, zone: &str) -> Result<Option<EngineVariable>> {
    let mut heaters =
        zone_equipment(model, zone)?.into_iter().filter(|item| is_one_of(&item.class, &HEATERS));
    let Some(heater) = heaters.find(|heater| heating_only::refuse_powerless(model, heater).is_ok()) else {
        return Ok(None);
    };
    switch_on(model, &heater)?;
    heating_only::heat(model, &heater).map(Some)
}

/// Schedules the minimum flow of a terminal. With the cooling setpoint out of reach and a damper that does not reverse
/// for heating, a terminal always has its minimum flow. The schedule is 0 because its value at the beginning of a run
/// is a lower limit for the whole run.
fn schedule_damper(model: &mut Model, zone: &str, terminal: &Reference) -> Result<String> {
    let name = format!("{zone} Damper Opening");
    constant_schedule(model, &name, 0.0);
    let fields = model.require_mut(&terminal.class, &terminal.name)?;
    fields.retain(|field, _| {
        !field.contains("minimum_air_flow")
            && !field.starts_with("maximum_flow_")
            && !field.contains("turndown")
    });
    fields.insert("zone_minimum_air_flow_input_method".into(), "Scheduled".into());
    fields.insert("minimum_air_flow_fraction_schedule_name".into(), name.clone().into());
    if terminal.class.eq_ignore_ascii_case(REHEAT) {
        fields.insert("damper_heating_action".into(), "Normal".into());
    }
    Ok(name)
}
