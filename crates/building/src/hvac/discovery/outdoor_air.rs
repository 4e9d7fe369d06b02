//! Outdoor air of air loops that keep their own controls.

use crate::hvac::air_loop_graph::supply_components;
use crate::hvac::distribution::served_zones;
use crate::hvac::references::is_one_of;
use crate::hvac::system::System;
use crate::hvac::ventilation::Ventilation;
use crate::model::text;
use crate::{Model, Result};

const SYSTEM: &str = "AirLoopHVAC:OutdoorAirSystem";
const CONTROLLER: &str = "Controller:OutdoorAir";

/// Returns the outdoor air of every air loop that is not one of the systems, with the zones that it serves.
pub(super) fn left_alone(
    model: &Model,
    systems: &[Box<dyn System>],
    air_density: f64,
) -> Result<Vec<(Ventilation, Vec<String>)>> {
    let mut found = Vec::new();
    for air_loop in model.names("AirLoopHVAC") {
        let served = served_zones(model, &air_loop).unwrap_or_default();
        let zones: Vec<String> = served.into_iter().map(|served| served.zone).collect();
        if systems.iter().any(|system| reports_for(&**system, &zones)) {
            continue;
        }
        if let Some(controller) = controller(model, &air_loop)? {
            found.push((Ventilation::of(model, &controller, air_density)?, zones));
        }
    }
    Ok(found)
}

/// Returns whether a system has the outdoor air of one of these zones.
fn reports_for(system: &dyn System, zones: &[String]) -> bool {
    let is_own = |zone: &String| system.zones().iter().any(|own| own.eq_ignore_ascii_case(zone));
    system.ventilation().is_some() && zones.iter().any(is_own)
}

/// Returns the outdoor air controller of an air loop, if it has one.
fn controller(model: &Model, air_loop: &str) -> Result<Option<String>> {
    let components = supply_components(model, air_loop)?;
    let Some(system) = components.iter().find(|component| is_one_of(&component.class, &[SYSTEM])) else {
        return Ok(None);
    };
    let list = text(model.require(&system.class, &system.name)?, "controller_list_name");
    let Some(controllers) = list.and_then(|list| model.get("AirLoopHVAC:ControllerList", list)) else {
        return Ok(None);
    };
    let is_outdoor = |number: &usize| {
        text(controllers, &format!("controller_{number}_object_type"))
            .is_some_and(|class| class.eq_ignore_ascii_case(CONTROLLER))
    };
    let name =
        (1..=8).find(is_outdoor).and_then(|number| text(controllers, &format!("controller_{number}_name")));
    Ok(name.map(str::to_owned))
}
