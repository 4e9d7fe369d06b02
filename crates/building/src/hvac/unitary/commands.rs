//! The two commands of a unit: air flow and supply air temperature.

use serde_json::json;

use super::unit::{Nodes, TERMINALS, Unit, VARIABLE};
use crate::hvac::distribution::ServedZone;
use crate::hvac::references::{Reference, is_one_of, required};
use crate::hvac::schedules::{ALWAYS_ON, constant_schedule};
use crate::hvac::setpoint_managers::remove_setpoint_managers;
use crate::hvac::zone_equipment::put_first;
use crate::model::Model;
use crate::{Error, Result};

/// The control schedules of a zone's unit.
pub(super) struct Schedules {
    pub(super) flow: String,
    pub(super) temperature: String,
}

/// An edited terminal.
pub(super) struct Terminal {
    /// Volume flow, m³/s.
    pub(super) design_flow: f64,
    pub(super) outlet: String,
}

/// Name of the schedule of a zone's flow command, as a fraction of its terminal's design flow.
pub fn supply_air_flow_fraction(zone: &str) -> String {
    format!("{zone} Supply Air Flow Fraction")
}

/// Name of the schedule of a zone's supply air temperature command, °C.
pub fn supply_air_temperature(zone: &str) -> String {
    format!("{zone} Supply Air Temperature")
}

impl Schedules {
    pub(super) fn insert(model: &mut Model, zone: &str) -> Self {
        let schedules =
            Self { flow: supply_air_flow_fraction(zone), temperature: supply_air_temperature(zone) };
        constant_schedule(model, &schedules.flow, 0.0);
        constant_schedule(model, &schedules.temperature, 20.0);
        schedules
    }
}

/// Puts one scheduled setpoint on every node from the cooling coil to the demand side, in place of all others.
pub(super) fn follow_supply_temperature(model: &mut Model, unit: &Unit, nodes: &Nodes, schedule: &str) {
    let driven = [&nodes.cooling, &nodes.heating, unit.outlet(), &unit.demand_inlet];
    remove_setpoint_managers(model, &unit.old_nodes);
    let list = format!("{} Setpoint Nodes", unit.air_loop);
    let mut unique: Vec<&str> = driven.to_vec();
    unique.dedup();
    model.insert(
        "NodeList",
        &list,
        json!({"nodes": unique.iter().map(|n| json!({"node_name": n})).collect::<Vec<_>>()}),
    );
    model.insert(
        "SetpointManager:Scheduled",
        &format!("{} Supply Setpoint", unit.air_loop),
        json!({
            "control_variable": "Temperature",
            "schedule_name": schedule,
            "setpoint_node_or_nodelist_name": list,
        }),
    );
}

/// Makes the minimum flow of the terminal of a zone follow the command: with the cooling setpoint of the zone out of
/// reach, it never requests more.
pub(super) fn follow_flow(model: &mut Model, served: &ServedZone, schedule: &str) -> Result<Terminal> {
    let ServedZone { zone, unit: distribution, terminal: Reference { class, name } } = served;
    if !is_one_of(class, &TERMINALS) {
        return Err(Error::unsupported(
            class,
            name,
            "unsupported terminal; a unitary system must feed one without reheat",
        ));
    }
    let design_flow = model.require_size(class, name, "maximum_air_flow_rate")?;
    put_first(model, zone, distribution)?;
    let fields = model.require_mut("ZoneHVAC:AirDistributionUnit", distribution)?;
    fields.insert("air_terminal_object_type".into(), json!(VARIABLE));
    let old = model.take(class, name)?;
    let outlet = required(&old, class, name, "air_outlet_node_name")?;
    model.insert(
        VARIABLE,
        name,
        json!({
            "availability_schedule_name": ALWAYS_ON,
            "air_inlet_node_name": required(&old, class, name, "air_inlet_node_name")?,
            "air_outlet_node_name": outlet,
            "maximum_air_flow_rate": design_flow,
            "zone_minimum_air_flow_input_method": "Scheduled",
            "minimum_air_flow_fraction_schedule_name": schedule,
        }),
    );
    Ok(Terminal { design_flow, outlet })
}
