//! Units modeled as separate components: cooling coil, heating coil and fan in series on the branch of an air loop. The
//! heating coil may be a heat pump's, with or without a backup.

use serde_json::json;

use super::heat_pump;
use super::unit::{HEATERS, TERMINALS, UNITARY_SYSTEM, coil};
use crate::hvac::air_loop_graph::{Component, components, only_branch, set_components, supply_components};
use crate::hvac::distribution::served_zones;
use crate::hvac::references::{Reference, is_one_of};
use crate::model::Model;
use crate::{Error, Result};

const OUTDOOR_AIR_SYSTEM: &str = "AirLoopHVAC:OutdoorAirSystem";
const COOLING_SYSTEM: &str = "CoilSystem:Cooling:DX";
const COOLING: [&str; 4] =
    [COOLING_SYSTEM, "Coil:Cooling:DX:SingleSpeed", "Coil:Cooling:DX:TwoSpeed", "Coil:Cooling:DX:MultiSpeed"];
const FANS: [&str; 4] = ["Fan:ConstantVolume", "Fan:OnOff", "Fan:SystemModel", "Fan:VariableVolume"];

/// The parts of a unit.
struct Parts {
    cooling: Reference,
    heating: Reference,
    /// The backup of a heat pump.
    supplemental: Option<Reference>,
    fan: Reference,
}

/// Returns whether an air loop has the parts of a unit, and nothing else, ahead of terminals that a unit can feed.
pub(super) fn has_parts(model: &Model, air_loop: &str) -> Result<bool> {
    let feeds_terminals = || {
        let served = served_zones(model, air_loop);
        served.is_ok_and(|served| served.iter().all(|s| is_one_of(&s.terminal.class, &TERMINALS)))
    };
    Ok(parts(&supply_components(model, air_loop)?).is_some() && feeds_terminals())
}

/// Replaces the parts of a unit on the branch with a unitary system. Its nodes and controls follow when the unit is
/// rewritten. Without parts the model does not change.
pub(super) fn assemble(model: &mut Model, air_loop: &str) -> Result<()> {
    let Some(parts) = parts(&supply_components(model, air_loop)?) else { return Ok(()) };
    let name = format!("{air_loop} Unit");
    put_on_branch(model, air_loop, &name)?;
    let mut unit = json!({"supply_fan_object_type": parts.fan.class, "supply_fan_name": parts.fan.name});
    let coils = [
        ("cooling", Some(coil_within(model, parts.cooling, COOLING_SYSTEM, "cooling_coil")?)),
        ("heating", Some(coil_within(model, parts.heating, heat_pump::SYSTEM, "heating_coil")?)),
        ("supplemental_heating", parts.supplemental),
    ];
    for (which, coil) in coils.into_iter().filter_map(|(which, coil)| Some((which, coil?))) {
        unit[format!("{which}_coil_object_type")] = json!(coil.class);
        unit[format!("{which}_coil_name")] = json!(coil.name);
    }
    model.insert(UNITARY_SYSTEM, &name, unit);
    Ok(())
}

/// Returns the parts if there are one cooling coil, one heating coil or a heat pump's and its backup, one fan, and
/// nothing else but outdoor air.
fn parts(components: &[Reference]) -> Option<Parts> {
    let inside: Vec<_> = components.iter().filter(|c| !is_outdoor_air(&c.class)).collect();
    let one = |classes: &[&str]| inside.iter().find(|c| is_one_of(&c.class, classes)).map(|c| (*c).clone());
    let (heating, supplemental) = match (one(&[heat_pump::SYSTEM]), one(&HEATERS)) {
        (Some(heat_pump), backup) => (heat_pump, backup),
        (None, heater) => (heater?, None),
    };
    let count = 3 + usize::from(supplemental.is_some());
    let parts = Parts { cooling: one(&COOLING)?, heating, supplemental, fan: one(&FANS)? };
    (inside.len() == count).then_some(parts)
}

fn is_outdoor_air(class: &str) -> bool {
    class.eq_ignore_ascii_case(OUTDOOR_AIR_SYSTEM)
}

/// Returns the coil itself; removes a coil system of this class around it.
fn coil_within(model: &mut Model, found: Reference, system: &str, which: &str) -> Result<Reference> {
    if !found.class.eq_ignore_ascii_case(system) {
        return Ok(found);
    }
    let fields = model.take(&found.class, &found.name)?;
    coil(&fields, which).ok_or_else(|| Error::unsupported(&found.class, &found.name, "it has no coil"))
}

/// Replaces the parts on the branch with the unit, downstream of outdoor air if there is any.
fn put_on_branch(model: &mut Model, air_loop: &str, unit: &str) -> Result<()> {
    let branch = only_branch(model, air_loop)?;
    let (mut outside, parts): (Vec<_>, Vec<_>) =
        components(model, &branch)?.into_iter().partition(|c| is_outdoor_air(&c.object.class));
    let inlet = parts.first().map_or("", |part| &part.inlet);
    let outlet = parts.last().map_or("", |part| &part.outlet);
    outside.push(Component::new(UNITARY_SYSTEM, unit, inlet, outlet));
    set_components(model, &branch, &outside)
}
