//! A unit that the model has in parts: cooling coil, heating coil and fan, one after the other on the branch of an
//! air loop.

use serde_json::{Value, json};

use super::super::common::{self, Reference, is_one_of, unsupported};
use super::super::distribution::served_zones;
use super::{HEATERS, TERMINALS, UNITARY_SYSTEM, component};
use crate::Result;
use crate::model::{Model, text};

const OUTDOOR_AIR_SYSTEM: &str = "AirLoopHVAC:OutdoorAirSystem";
const COOLING_SYSTEM: &str = "CoilSystem:Cooling:DX";
const COOLING: [&str; 4] =
    [COOLING_SYSTEM, "Coil:Cooling:DX:SingleSpeed", "Coil:Cooling:DX:TwoSpeed", "Coil:Cooling:DX:MultiSpeed"];
const FANS: [&str; 4] = ["Fan:ConstantVolume", "Fan:OnOff", "Fan:SystemModel", "Fan:VariableVolume"];

/// The parts of a unit.
struct Parts {
    cooling: Reference,
    heating: Reference,
    fan: Reference,
}

/// Whether an air loop has the parts of a unit, and nothing else, ahead of terminals that a unit can feed.
pub(super) fn has_parts(model: &Model, air_loop: &str) -> Result<bool> {
    let feeds_terminals = || {
        let served = served_zones(model, air_loop);
        served.is_ok_and(|served| served.iter().all(|s| is_one_of(&s.terminal.class, &TERMINALS)))
    };
    Ok(parts(&common::supply_components(model, air_loop)?).is_some() && feeds_terminals())
}

/// Puts a unitary system in the place of its parts on the branch. It has no nodes and no control yet: all of that is
/// rewritten with the rest of a unit. Nothing changes where there are no parts.
pub(super) fn assemble(model: &mut Model, air_loop: &str) -> Result<()> {
    let Some(parts) = parts(&common::supply_components(model, air_loop)?) else { return Ok(()) };
    let name = format!("{air_loop} Unit");
    put_on_branch(model, air_loop, &name)?;
    let cooling = cooling_coil(model, parts.cooling)?;
    model.insert(
        UNITARY_SYSTEM,
        &name,
        json!({
            "supply_fan_object_type": parts.fan.class, "supply_fan_name": parts.fan.name,
            "cooling_coil_object_type": cooling.class, "cooling_coil_name": cooling.name,
            "heating_coil_object_type": parts.heating.class, "heating_coil_name": parts.heating.name,
        }),
    );
    Ok(())
}

/// One cooling coil, one heating coil, one fan and no more, but for outdoor air.
fn parts(components: &[Reference]) -> Option<Parts> {
    let inside: Vec<_> = components.iter().filter(|c| !is_outdoor_air(&c.class)).collect();
    let one = |classes: &[&str]| inside.iter().find(|c| is_one_of(&c.class, classes)).map(|c| (*c).clone());
    let parts = Parts { cooling: one(&COOLING)?, heating: one(&HEATERS)?, fan: one(&FANS)? };
    (inside.len() == 3).then_some(parts)
}

fn is_outdoor_air(class: &str) -> bool {
    class.eq_ignore_ascii_case(OUTDOOR_AIR_SYSTEM)
}

/// The coil itself: a coil system around it goes.
fn cooling_coil(model: &mut Model, cooling: Reference) -> Result<Reference> {
    if !cooling.class.eq_ignore_ascii_case(COOLING_SYSTEM) {
        return Ok(cooling);
    }
    let system = super::take(model, &cooling.class, &cooling.name)?;
    let coil = super::coil(&system, "cooling_coil");
    let (class, name) = coil.ok_or_else(|| unsupported(&cooling.class, &cooling.name, "it has no coil"))?;
    Ok(Reference { class, name })
}

/// The branch goes from outdoor air, if there is any, through the unit.
fn put_on_branch(model: &mut Model, air_loop: &str, unit: &str) -> Result<()> {
    let name = common::only_branch(model, air_loop)?;
    let branch = model.require_mut("Branch", &name)?;
    let parts: Vec<_> = common::items(branch, "components").cloned().collect();
    let is_part = |c: &crate::model::Fields| !text(c, "component_object_type").is_some_and(is_outdoor_air);
    let node = |part: Option<&crate::model::Fields>, end: &str| {
        part.and_then(|part| text(part, end)).unwrap_or_default().to_owned()
    };
    let inlet = node(parts.iter().find(|c| is_part(c)), "component_inlet_node_name");
    let outlet = node(parts.iter().rfind(|c| is_part(c)), "component_outlet_node_name");
    let mut components: Vec<Value> = parts.into_iter().filter(|c| !is_part(c)).map(Value::Object).collect();
    components.push(component(UNITARY_SYSTEM, unit, &inlet, &outlet));
    branch.insert("components".into(), components.into());
    Ok(())
}
