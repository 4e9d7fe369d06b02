//! Discovery of the systems of a model that can be controlled, and of those that cannot, with the reason.
//!
//! [`super::make_controllable`] fails at the first unsupported system. In a user's model each system is tried on its own:
//! one that is not supported keeps its thermostats, schedules and availability.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::air_loop_graph::supply_components;
use super::controllable::{UNCONTROLLED_EQUIPMENT, drive_air_loop};
use super::distribution::served_zones;
use super::energy_management::{objects, remove_ems_programs, sets_a_schedule, silence_sensors};
use super::heating_only;
use super::references::{Reference, is_one_of, parts};
use super::system::System;
use super::thermostat::{split_thermostats, thermostat};
use super::zone_equipment::zone_equipment;
use crate::model::{Fields, Model, text};
use crate::{Error, Result};

/// The systems found in a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Discovery {
    /// The controlled systems, in the order of the action.
    pub systems: Vec<System>,
    /// The systems and the equipment that are not controlled.
    pub uncontrolled: Vec<Uncontrolled>,
}

/// A system or a piece of zone equipment that is not controlled: it keeps its own controls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Uncontrolled {
    /// The air loop or the equipment.
    pub object: Reference,
    /// The zones it serves.
    pub zones: Vec<String>,
    /// The reason why it is not controlled, or how it works alongside controlled equipment.
    pub reason: String,
}

const DISTRIBUTION: &str = "ZoneHVAC:AirDistributionUnit";
/// Zone equipment that moves air without controlling a temperature.
const VENTILATION: [&str; 2] = ["Fan:ZoneExhaust", "ZoneHVAC:EnergyRecoveryVentilator"];

/// Makes every supported system of a hard-sized model controllable: air loops in model order, then heaters in the order of
/// their zones.
///
/// # Errors
/// [`Error::MissingObject`] for a dangling reference.
pub(crate) fn discover(model: &mut Model, air_density: f64) -> Result<Discovery> {
    let before = objects(model);
    split_thermostats(model);
    let mut found = Discovery::default();
    for air_loop in model.names("AirLoopHVAC") {
        let own = belongings(model, &air_loop)?;
        let controlled = attempt(model, |model| {
            refuse_second_system(model, &air_loop)?;
            drive_air_loop(model, &air_loop, air_density)
        });
        match controlled {
            Ok(system) => {
                remove_ems_programs(model, |actuator| acts_on(actuator, &own));
                found.systems.push(system);
            }
            Err(error) => found.uncontrolled.push(uncontrolled_air_loop(model, air_loop, error)?),
        }
    }
    for zone in model.names("Zone") {
        discover_equipment(model, &zone, &mut found)?;
    }
    silence_sensors(model, &before);
    Ok(found)
}

impl Discovery {
    /// Returns why systems are not controlled, one line for all of a class with the same reason.
    pub(crate) fn reasons(&self) -> Vec<String> {
        let mut groups: Vec<(&str, &str, usize)> = Vec::new();
        for Uncontrolled { object, reason, .. } in &self.uncontrolled {
            match groups.iter_mut().find(|(class, why, _)| *class == object.class && why == reason) {
                Some((_, _, count)) => *count += 1,
                None => groups.push((&object.class, reason, 1)),
            }
        }
        groups.iter().map(|(class, reason, count)| format!("{count} × {class}: {reason}")).collect()
    }

    fn controls(&self, zone: &str) -> Option<&System> {
        self.systems.iter().find(|s| s.zones().iter().any(|z| z.eq_ignore_ascii_case(zone)))
    }
}

/// Returns whether a zone without controlled equipment has a thermostat and equipment that heats or cools it.
pub(crate) fn has_own_controls(model: &Model, zone: &str) -> Result<bool> {
    let conditions = |e: &Reference| !is_one_of(&e.class, &VENTILATION);
    Ok(thermostat(model, zone).is_some() && zone_equipment(model, zone)?.iter().any(conditions))
}

/// Applies an edit; on failure the model is not changed.
fn attempt(model: &mut Model, edit: impl FnOnce(&mut Model) -> Result<System>) -> Result<System> {
    let mut edited = model.clone();
    let system = edit(&mut edited)?;
    *model = edited;
    Ok(system)
}

/// Rejects an air loop with a second system in one of its zones: a packaged unit or another air loop would follow the same
/// thermostat.
fn refuse_second_system(model: &Model, air_loop: &str) -> Result<()> {
    let mut units = HashSet::new();
    let served = served_zones(model, air_loop)?;
    for zone in &served {
        if !units.insert(zone.zone.to_lowercase()) {
            let why = format!("two of its terminals are in zone `{}`", zone.zone);
            return Err(Error::unsupported("AirLoopHVAC", air_loop, &why));
        }
        for equipment in zone_equipment(model, &zone.zone)? {
            let own = equipment.name.eq_ignore_ascii_case(&zone.unit);
            if !own && !is_beside(&equipment.class) {
                let why =
                    format!("one of its zones also has a {} under the same thermostat", equipment.class);
                return Err(Error::unsupported("AirLoopHVAC", air_loop, &why));
            }
        }
    }
    Ok(())
}

/// Returns whether equipment may share a zone with a controlled system.
fn is_beside(class: &str) -> bool {
    is_one_of(class, &VENTILATION)
        || is_one_of(class, &UNCONTROLLED_EQUIPMENT)
        || heating_only::is_heater(class)
}

fn uncontrolled_air_loop(model: &Model, air_loop: String, error: Error) -> Result<Uncontrolled> {
    let reason = reason(error, &air_loop)?;
    let zones = served_zones(model, &air_loop).map(|served| served.into_iter().map(|s| s.zone).collect());
    let object = Reference { class: "AirLoopHVAC".into(), name: air_loop };
    Ok(Uncontrolled { object, zones: zones.unwrap_or_default(), reason })
}

/// Returns the reason in an error, with the class of its object unless that is the system itself.
fn reason(error: Error, system: &str) -> Result<String> {
    match error {
        Error::Unsupported { name, why, .. } if name.eq_ignore_ascii_case(system) => Ok(why),
        Error::Unsupported { class, why, .. } => Ok(format!("its {class}: {why}")),
        other => Err(other),
    }
}

/// Makes the heater of a zone controllable if nothing else conditions the zone, and records why other equipment is not
/// controlled.
fn discover_equipment(model: &mut Model, zone: &str, found: &mut Discovery) -> Result<()> {
    let equipment = zone_equipment(model, zone)?;
    let air = found.controls(zone).cloned();
    let rival = |e: &&Reference| !is_beside(&e.class);
    let mut controlled = false;
    for item in &equipment {
        let reason = match &air {
            _ if item.class.eq_ignore_ascii_case(DISTRIBUTION) => continue,
            _ if is_one_of(&item.class, &VENTILATION) => "it ventilates by its own schedule".to_owned(),
            Some(System::AirLoop(_)) if heating_only::is_heater(&item.class) => {
                "it holds the heating setpoint together with the terminal of the zone".to_owned()
            }
            Some(_) if heating_only::is_heater(&item.class) => {
                "it stays off: the air system of the zone heats, and the thermostat never calls for heat"
                    .to_owned()
            }
            Some(_) => "unsupported component: it follows the controlled thermostat".to_owned(),
            None if !heating_only::is_heater(&item.class) => "unsupported component".to_owned(),
            None if controlled => {
                "it holds the heating setpoint together with the first heater of the zone".to_owned()
            }
            None => match equipment.iter().find(rival) {
                Some(rival) => format!("a {} in the zone follows the same thermostat", rival.class),
                None => {
                    let made = attempt(model, |model| {
                        Ok(System::HeatingOnly(heating_only::make_controllable(model, zone, item)?))
                    });
                    match made {
                        Ok(system) => {
                            controlled = true;
                            found.systems.push(system);
                            continue;
                        }
                        Err(error) => reason(error, &item.name)?,
                    }
                }
            },
        };
        found.uncontrolled.push(Uncontrolled { object: item.clone(), zones: vec![zone.to_owned()], reason });
    }
    Ok(())
}

/// Returns every name in the objects of an air loop, in lower case: its components and their parts, nodes, terminals, zones.
fn belongings(model: &Model, air_loop: &str) -> Result<HashSet<String>> {
    let mut names = HashSet::from([air_loop.to_lowercase()]);
    for component in supply_components(model, air_loop)? {
        collect(model, &component, &mut names);
    }
    for served in served_zones(model, air_loop).unwrap_or_default() {
        collect(model, &served.terminal, &mut names);
        names.insert(served.zone.to_lowercase());
    }
    for (controller, fields) in model.objects("Controller:OutdoorAir") {
        if text(fields, "mixed_air_node_name").is_some_and(|node| names.contains(&node.to_lowercase())) {
            names.insert(controller.to_lowercase());
        }
    }
    Ok(names)
}

fn collect(model: &Model, object: &Reference, names: &mut HashSet<String>) {
    names.insert(object.name.to_lowercase());
    let Some(fields) = model.get(&object.class, &object.name) else { return };
    names.extend(fields.values().filter_map(Value::as_str).map(str::to_lowercase));
    for part in parts(fields) {
        collect(model, &part, names);
    }
}

/// Returns whether an EMS actuator acts on a component of a controlled system. Schedules do not count: a controlled system no
/// longer follows those of the model.
fn acts_on(actuator: &Fields, names: &HashSet<String>) -> bool {
    !sets_a_schedule(actuator)
        && text(actuator, "actuated_component_unique_name").is_some_and(|n| names.contains(&n.to_lowercase()))
}

#[cfg(test)]
mod tests;
