//! A heat pump's heating coils behind the unit, on its branch.
//!
//! Inside the unit the engine would look for the compressor's other coil at every call, and never find a two-speed one:
//! a sixth of a year's time. Each coil has the setpoint that it would have inside.

use serde_json::{Value, json};

use super::{Coil, HEATERS, Nodes, UNITARY_SYSTEM, Unit, component, unit_component};
use crate::Result;
use crate::hvac::common::{self, Reference};
use crate::model::{Model, text};

pub(super) const HEATING_COIL: &str = "Coil:Heating:DX:SingleSpeed";
const SYSTEM: &str = "CoilSystem:Heating:DX";

/// Puts the heating coil and its backup behind the cooling coil, and returns their components of the branch.
pub(super) fn stand_apart(
    model: &mut Model,
    unit: &Unit,
    nodes: &Nodes,
    heating: &Coil,
    backup: Option<&Coil>,
) -> Result<Vec<Value>> {
    let (class, name) = heating;
    let system = format!("{name} System");
    model.insert(
        SYSTEM,
        &system,
        json!({
            "availability_schedule_name": common::ALWAYS_ON,
            "heating_coil_object_type": class,
            "heating_coil_name": name,
        }),
    );
    let mut components = vec![component(SYSTEM, &system, &nodes.cooling, &nodes.heating)];
    if let Some((class, name)) = backup {
        let fields = model.require_mut(class, name)?;
        fields.insert("temperature_setpoint_node_name".into(), json!(unit.outlet));
        components.push(component(class, name, &nodes.heating, &unit.outlet));
    }
    Ok(components)
}

/// Takes heating coils that stand behind a unit back into it. Nothing changes where there are none.
pub(super) fn rejoin(model: &mut Model, air_loop: &str) -> Result<()> {
    let Some((branch, _)) = unit_component(model, air_loop)? else { return Ok(()) };
    let components: Vec<_> =
        common::items(model.require("Branch", &branch)?, "components").cloned().collect();
    let part = |at: usize| common::reference(components.get(at)?, "component_object_type", "component_name");
    let is = |part: &Reference, classes: &[&str]| common::is_one_of(&part.class, classes);
    let Some(at) = (1..components.len()).find(|at| part(*at).is_some_and(|part| is(&part, &[SYSTEM]))) else {
        return Ok(());
    };
    let (Some(unit), Some(system)) = (part(at - 1).filter(|part| is(part, &[UNITARY_SYSTEM])), part(at))
    else {
        return Ok(());
    };
    let backup = part(at + 1).filter(|part| is(part, &HEATERS));
    let last = at + usize::from(backup.is_some());
    let Some(heating) = super::coil(model.require(&system.class, &system.name)?, "heating_coil") else {
        return Ok(());
    };
    let fields = model.require_mut(&unit.class, &unit.name)?;
    for (which, coil) in
        [("heating", Some(heating)), ("supplemental_heating", backup.map(|b| (b.class, b.name)))]
    {
        if let Some((class, name)) = coil {
            fields.insert(format!("{which}_coil_object_type"), json!(class));
            fields.insert(format!("{which}_coil_name"), json!(name));
        }
    }
    model.remove(&system.class, &system.name);
    let end = |at: usize, end: &str| text(&components[at], end).unwrap_or_default();
    let (inlet, outlet) = ("component_inlet_node_name", "component_outlet_node_name");
    let whole = component(&unit.class, &unit.name, end(at - 1, inlet), end(last, outlet));
    let branch = model.require_mut("Branch", &branch)?;
    if let Some(components) = branch.get_mut("components").and_then(Value::as_array_mut) {
        components.splice(at - 1..=last, [whole]);
    }
    Ok(())
}
