//! Water coils of an air handler, whose valve follows the setpoint downstream of the coil.

use crate::hvac::references::Reference;
use crate::model::{Model, number, text};
use crate::{Error, Result};

const CONTROLLER: &str = "Controller:WaterCoil";
/// Heating capacity per water flow of a coil designed for a temperature drop of 11 K, W per m³/s.
const HEAT_PER_FLOW: f64 = 11.0 * 4.18e6;

/// Points the controller of a water coil to the temperature of the coil's outlet node. Other coils need nothing.
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
        let why = format!("it controls {variable}; expected Temperature");
        return Err(Error::unsupported(CONTROLLER, controller, &why));
    }
    let controller = controller.to_owned();
    model.require_mut(CONTROLLER, &controller)?.insert("sensor_node_name".into(), outlet.into());
    Ok(())
}

/// Returns the design capacity of a heating coil, W.
pub(super) fn capacity(model: &Model, coil: &Reference) -> Result<f64> {
    match number(model.require(&coil.class, &coil.name)?, "rated_capacity") {
        Some(capacity) => Ok(capacity),
        None => Ok(HEAT_PER_FLOW * model.require_size(&coil.class, &coil.name, "maximum_water_flow_rate")?),
    }
}
