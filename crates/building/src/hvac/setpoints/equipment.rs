//! The equipment that follows a zone's thermostat, and what it can do. Radiant systems and others that hold temperatures
//! of their own schedules do not follow it.

use std::collections::HashSet;

use crate::hvac::air_loop_graph::supply_components;
use crate::hvac::capacity::air_loop_of;
use crate::hvac::heating_only::refuse_powerless;
use crate::hvac::references::{Reference, is_one_of};
use crate::hvac::thermostat::governs;
use crate::hvac::zone_equipment::{HEATERS, UNCONTROLLED, VENTILATION, is_distribution, zone_equipment};
use crate::model::{Fields, begins, number, text};
use crate::{Error, Model, Result};

/// A terminal that passes the air of its loop regardless of what the zone's thermostat calls for.
const PASSES: &str = "AirTerminal:SingleDuct:ConstantVolume:NoReheat";
/// Beginning of the classes of baseboards.
const BASEBOARD: &str = "ZoneHVAC:Baseboard:";
/// Field of equipment for the schedule of its cooling.
const COOLING_SWITCH: &str = "cooling_availability_schedule_name";

/// Ends of the names of the fields for schedules of temperatures that equipment holds.
const OWN_TEMPERATURES: [&str; 2] =
    ["control_temperature_schedule_name", "setpoint_temperature_schedule_name"];

/// Returns whether equipment of a zone, or the design that it names, has schedules of the temperatures that it holds,
/// whatever the zone's thermostat calls for.
pub(in crate::hvac) fn has_own_temperatures(model: &Model, item: &Reference) -> bool {
    let Some(own) = model.get(&item.class, &item.name) else { return false };
    let design =
        text(own, "design_object").and_then(|name| model.get(&format!("{}:Design", item.class), name));
    let holds = |fields: &Fields| {
        let mut schedules =
            fields.keys().filter(|field| OWN_TEMPERATURES.iter().any(|end| field.ends_with(end)));
        schedules.any(|field| text(fields, field).is_some())
    };
    [Some(own), design].into_iter().flatten().any(holds)
}

/// Returns the equipment of a zone that heats or cools it.
pub(super) fn conditioning(model: &Model, zone: &str) -> Result<Vec<Reference>> {
    let mut equipment = zone_equipment(model, zone)?;
    equipment.retain(|item| !is_one_of(&item.class, &VENTILATION));
    Ok(equipment)
}

/// Rejects a zone whose setpoints have no effect: it has only heaters without capacity, or only terminals that pass the
/// air of a unit that follows another zone's thermostat or none.
pub(super) fn refuse_deaf(model: &Model, zone: &str, equipment: &[Reference]) -> Result<()> {
    if equipment.iter().all(|item| is_one_of(&item.class, &HEATERS)) {
        let mut powerless = equipment.iter().map(|heater| refuse_powerless(model, heater));
        return if powerless.any(|refused| refused.is_ok()) {
            Ok(())
        } else {
            refuse_powerless(model, &equipment[0])
        };
    }
    if !equipment.iter().all(|item| passes(model, item)) || !is_deaf(model, zone)? {
        return Ok(());
    }
    let name = air_loop_of(model, zone)?.unwrap_or_default();
    let why = format!("its terminal passes the air of `{name}`, which does not follow the zone's thermostat");
    Err(Error::unsupported("Zone", zone, &why))
}

/// Returns whether equipment of a zone is a terminal that passes the air of its loop, and the loop does not follow the
/// thermostat of the zone, like dedicated outdoor air.
pub(in crate::hvac) fn passes_regardless(model: &Model, zone: &str, item: &Reference) -> Result<bool> {
    Ok(passes(model, item) && is_deaf(model, zone)?)
}

fn passes(model: &Model, item: &Reference) -> bool {
    let unit = model.get(&item.class, &item.name);
    let terminal = unit.and_then(|unit| text(unit, "air_terminal_object_type"));
    is_distribution(&item.class) && terminal.is_some_and(|class| class.eq_ignore_ascii_case(PASSES))
}

/// Returns whether the air loop of a zone does not follow its thermostat.
fn is_deaf(model: &Model, zone: &str) -> Result<bool> {
    let air_loop = air_loop_of(model, zone)?;
    let follows = air_loop.is_some_and(|air_loop| follows_all_zones(model, &air_loop));
    Ok(!follows && !governs(model, zone))
}

/// Returns whether the supply air of a loop follows the loads of all its zones.
fn follows_all_zones(model: &Model, air_loop: &str) -> bool {
    let names = |fields: &Fields| {
        text(fields, "hvac_air_loop_name").is_some_and(|name| name.eq_ignore_ascii_case(air_loop))
    };
    let mut managers = model.classes().filter(|class| class.starts_with("SetpointManager:"));
    managers.any(|class| model.objects(class).into_iter().any(|(_, fields)| names(fields)))
}

/// Returns whether equipment of a zone, or the air loop that serves it, can cool.
pub(super) fn cools(model: &Model, zone: &str, equipment: &[Reference]) -> Result<bool> {
    let only_heats = |item: &Reference| {
        let is_heater = begins(&item.class, BASEBOARD) || is_one_of(&item.class, &HEATERS);
        is_heater || is_one_of(&item.class, &UNCONTROLLED) || has_no_cooling(model, item)
    };
    let own = equipment.iter().any(|item| !is_distribution(&item.class) && !only_heats(item));
    if own {
        return Ok(true);
    }
    match air_loop_of(model, zone)? {
        Some(air_loop) => Ok(has_cooler(model, supply_components(model, &air_loop)?)),
        None => Ok(equipment.iter().any(|item| is_distribution(&item.class))),
    }
}

/// Returns whether the cooling of equipment is switched off by a constant schedule.
fn has_no_cooling(model: &Model, item: &Reference) -> bool {
    let schedule = model.get(&item.class, &item.name).and_then(|own| text(own, COOLING_SWITCH));
    let constant = schedule.and_then(|name| model.get("Schedule:Constant", name));
    constant.is_some_and(|schedule| number(schedule, "hourly_value") == Some(0.0))
}

/// Returns whether a component, or one that it consists of, is a cooling coil or an evaporative cooler.
fn has_cooler(model: &Model, mut components: Vec<Reference>) -> bool {
    let mut seen = HashSet::new();
    while let Some(Reference { class, name }) = components.pop() {
        let class = class.to_lowercase();
        if class.contains("cool") {
            return true;
        }
        if let Some(fields) = model.get(&class, &name)
            && seen.insert((class, name.to_lowercase()))
        {
            components.extend(consists_of(fields));
        }
    }
    false
}

/// The objects that an object names, as `…_object_type` with `…_name`.
pub(super) fn consists_of(fields: &Fields) -> Vec<Reference> {
    let parts = fields.keys().filter_map(|key| key.strip_suffix("_object_type"));
    let reference = |part: &str| {
        let field = |suffix: &str| text(fields, &format!("{part}_{suffix}")).map(str::to_owned);
        Some(Reference { class: field("object_type")?, name: field("name")? })
    };
    parts.filter_map(reference).collect()
}
