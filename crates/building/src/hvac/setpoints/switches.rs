//! Schedules that switch off the equipment of zones, regardless of their setpoints.

use std::collections::HashSet;

use super::equipment::{conditioning, consists_of};
use crate::hvac::air_loop_graph::supply_components;
use crate::hvac::capacity::air_loop_of;
use crate::hvac::energy_management::sets;
use crate::hvac::references::Reference;
use crate::model::text;
use crate::{Model, Result};

/// End of the names of the fields, such as `heating_availability_schedule_name`.
const SWITCH: &str = "availability_schedule_name";

/// An object of a zone's equipment, and a schedule that switches it off where it is zero.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Switch {
    /// The zone.
    pub(crate) zone: String,
    /// The equipment, one of its parts, or a component of the zone's air loop.
    pub(crate) object: Reference,
    /// The schedule.
    pub(crate) schedule: String,
    /// Whether it switches off all of the object, not only its heating or its cooling.
    is_whole: bool,
}

/// Returns the objects that are switched off all year. `shares` has the share of the time in which each switch is off.
pub(crate) fn absent(switches: &[Switch], shares: impl Iterator<Item = f64>) -> Vec<Reference> {
    let is_absent = |(switch, share): &(&Switch, f64)| switch.is_whole && *share >= 1.0;
    let absent = switches.iter().zip(shares).filter(is_absent);
    absent.map(|(switch, _)| switch.object.clone()).collect()
}

/// Returns the switches of the equipment that heats or cools the zones of a model, except the switches that EMS
/// programs set.
///
/// # Errors
/// [`crate::Error::MissingObject`] for a dangling reference.
pub(crate) fn switches_of_all(model: &Model) -> Result<Vec<Switch>> {
    let zones = model.names("Zone");
    let each = zones.iter().map(|zone| switches(model, zone)).collect::<Result<Vec<_>>>()?;
    Ok(each.into_iter().flatten().filter(|switch| !sets(model, &switch.schedule)).collect())
}

/// Returns the switches of the equipment of a zone, with the air handler of its loop.
fn switches(model: &Model, zone: &str) -> Result<Vec<Switch>> {
    let mut objects = conditioning(model, zone)?;
    if let Some(air_loop) = air_loop_of(model, zone)? {
        objects.extend(supply_components(model, &air_loop).unwrap_or_default());
    }
    let (mut seen, mut found) = (HashSet::new(), Vec::new());
    while let Some(object) = objects.pop() {
        let Some(fields) = model.get(&object.class, &object.name) else { continue };
        if !seen.insert((object.class.to_lowercase(), object.name.to_lowercase())) {
            continue;
        }
        for field in fields.keys().filter(|field| field.ends_with(SWITCH)) {
            let Some(schedule) = text(fields, field) else { continue };
            let (zone, object, schedule) = (zone.to_owned(), object.clone(), schedule.to_owned());
            found.push(Switch { zone, object, schedule, is_whole: field == SWITCH });
        }
        objects.extend(consists_of(fields));
    }
    Ok(found)
}
