//! Water coils of an air handler: their valve follows the setpoint behind the coil, through the controller that the
//! model has for it.

use crate::hvac::references::Reference;
use crate::model::{Model, number, text};
use crate::{Error, Result};

const CONTROLLER: &str = "Controller:WaterCoil";
/// Heat that a m³/s of water gives off in a coil designed for a drop of 11 K, W.
const HEAT_PER_FLOW: f64 = 11.0 * 4.18e6;

/// Has the controller of a coil look at the temperature of the coil's outlet node. Nothing to do for a coil without
/// water.
///
/// # Errors
/// [`crate::Error::Unsupported`] when a water coil has no controller of its own, or one that controls humidity.
pub(super) fn follow_outlet(model: &mut Model, coil: &Reference, outlet: &str) -> Result<()> {
    if !coil.class.to_ascii_lowercase().contains(":water") {
        return Ok(());
    }
    let fields = model.require(&coil.class, &coil.name)?;
    let Some(valve) = text(fields, "water_inlet_node_name").map(str::to_owned) else {
        return Err(Error::unsupported(&coil.class, &coil.name, "it has no water inlet node"));
    };
    let controls = |fields: &crate::model::Fields| {
        text(fields, "actuator_node_name").is_some_and(|node| node.eq_ignore_ascii_case(&valve))
    };
    let controllers = model.objects(CONTROLLER);
    let Some((controller, fields)) = controllers.into_iter().find(|(_, fields)| controls(fields)) else {
        return Err(Error::unsupported(&coil.class, &coil.name, &format!("it has no {CONTROLLER}")));
    };
    let variable = text(fields, "control_variable").unwrap_or("Temperature");
    if !variable.eq_ignore_ascii_case("Temperature") {
        let why = format!("it controls {variable}, which a supply temperature cannot command");
        return Err(Error::unsupported(CONTROLLER, controller, &why));
    }
    let controller = controller.to_owned();
    model.require_mut(CONTROLLER, &controller)?.insert("sensor_node_name".into(), outlet.into());
    Ok(())
}

/// Heat that a heating coil was sized for, W.
pub(super) fn capacity(model: &Model, coil: &Reference) -> Result<f64> {
    match number(model.require(&coil.class, &coil.name)?, "rated_capacity") {
        Some(capacity) => Ok(capacity),
        None => Ok(HEAT_PER_FLOW * model.require_size(&coil.class, &coil.name, "maximum_water_flow_rate")?),
    }
}
