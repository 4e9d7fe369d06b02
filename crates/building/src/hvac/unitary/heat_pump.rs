//! The heating coils of a heat pump downstream of the unit, on its branch.
//!
//! Inside the unit the engine would search for the companion coil of the compressor at every call, in vain if it is
//! two-speed, which takes a sixth of a run's time. Each coil has the setpoint that it would have inside.

use serde_json::json;

use super::unit::{HEATERS, Nodes, UNITARY_SYSTEM, Unit, coil, unit_component};
use crate::Result;
use crate::hvac::air_loop_graph::{Component, components, set_components};
use crate::hvac::references::{Reference, is_one_of};
use crate::hvac::schedules::ALWAYS_ON;
use crate::model::Model;

pub(super) const HEATING_COIL: &str = "Coil:Heating:DX:SingleSpeed";
pub(super) const SYSTEM: &str = "CoilSystem:Heating:DX";

/// Moves the heating coil and its backup downstream of the unit, and returns their components of the branch.
pub(super) fn move_coils_out(
    model: &mut Model,
    unit: &Unit,
    nodes: &Nodes,
    heating: &Reference,
    backup: Option<&Reference>,
) -> Result<Vec<Component>> {
    let system = format!("{} System", heating.name);
    model.insert(
        SYSTEM,
        &system,
        json!({
            "availability_schedule_name": ALWAYS_ON,
            "heating_coil_object_type": heating.class,
            "heating_coil_name": heating.name,
        }),
    );
    let mut behind = vec![Component::new(SYSTEM, &system, &nodes.cooling, &nodes.heating)];
    if let Some(Reference { class, name }) = backup {
        let fields = model.require_mut(class, name)?;
        fields.insert("temperature_setpoint_node_name".into(), json!(unit.outlet()));
        behind.push(Component::new(class, name, &nodes.heating, unit.outlet()));
    }
    Ok(behind)
}

/// Moves heating coils downstream of a unit back into it, if there are any.
pub(super) fn move_coils_in(model: &mut Model, air_loop: &str) -> Result<()> {
    let Some((branch, _)) = unit_component(model, air_loop)? else { return Ok(()) };
    let mut on_branch = components(model, &branch)?;
    let Some((at, last)) = unit_and_coils(&on_branch) else { return Ok(()) };
    let (unit, system) = (on_branch[at].object.clone(), on_branch[at + 1].object.clone());
    let backup = (last > at + 1).then(|| on_branch[last].object.clone());
    let Some(heating) = coil(model.require(&system.class, &system.name)?, "heating_coil") else {
        return Ok(());
    };
    let fields = model.require_mut(&unit.class, &unit.name)?;
    for (which, coil) in [("heating", Some(heating)), ("supplemental_heating", backup)] {
        if let Some(Reference { class, name }) = coil {
            fields.insert(format!("{which}_coil_object_type"), json!(class));
            fields.insert(format!("{which}_coil_name"), json!(name));
        }
    }
    model.remove(&system.class, &system.name);
    let whole = Component::new(&unit.class, &unit.name, &on_branch[at].inlet, &on_branch[last].outlet);
    on_branch.splice(at..=last, [whole]);
    set_components(model, &branch, &on_branch)
}

/// Positions of a unit with a heating coil behind it, and of the last of its coils.
fn unit_and_coils(components: &[Component]) -> Option<(usize, usize)> {
    let is = |at: usize, classes: &[&str]| {
        components.get(at).is_some_and(|component| is_one_of(&component.object.class, classes))
    };
    let system = (1..components.len()).find(|at| is(*at, &[SYSTEM]))?;
    let last = system + usize::from(is(system + 1, &HEATERS));
    is(system - 1, &[UNITARY_SYSTEM]).then_some((system - 1, last))
}
