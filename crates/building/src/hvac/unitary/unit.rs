//! The packaged unit of an air loop, as the model has it.

use std::collections::HashSet;

use super::outdoor_air::OutdoorAir;
use crate::hvac::air_loop_graph::{Component, branches, components};
use crate::hvac::distribution::{ServedZone, served_zones};
use crate::hvac::references::{Reference, is_one_of, nodes_of, parts, reference, required};
use crate::hvac::thermostat::governs;
use crate::hvac::zone_equipment::{HEATERS as ZONE_HEATERS, zone_equipment};
use crate::model::{Fields, Model, text};
use crate::{Error, Result};

/// Class of every unit that was made controllable.
pub(super) const UNITARY_SYSTEM: &str = "AirLoopHVAC:UnitarySystem";
/// Heating coils other than a heat pump's.
pub(super) const HEATERS: [&str; 2] = ["Coil:Heating:Fuel", "Coil:Heating:Electric"];
/// The terminal of a zone that shares the air of a unit with others.
pub(super) const CONSTANT: &str = "AirTerminal:SingleDuct:ConstantVolume:NoReheat";
pub(super) const VARIABLE: &str = "AirTerminal:SingleDuct:VAV:NoReheat";
/// The terminals that a unit can feed.
pub(super) const TERMINALS: [&str; 2] = [CONSTANT, VARIABLE];
/// The classes of units that can be made controllable.
const UNIT_CLASSES: [&str; 4] = [
    UNITARY_SYSTEM,
    "AirLoopHVAC:UnitaryHeatPump:AirToAir",
    "AirLoopHVAC:UnitaryHeatCool",
    "AirLoopHVAC:Unitary:Furnace:HeatCool",
];

/// The packaged unit of an air loop, as the model has it.
pub(super) struct Unit {
    pub(super) air_loop: String,
    pub(super) branch: String,
    /// The unit itself and the nodes at its ends.
    pub(super) component: Component,
    pub(super) demand_inlet: String,
    /// The zone whose thermostat controls the unit.
    pub(super) served: ServedZone,
    /// The other zones, whose terminals share its air.
    pub(super) followers: Vec<ServedZone>,
    pub(super) outdoor_air: Option<OutdoorAir>,
    /// Its original nodes, inside and at its ends, in lower case.
    pub(super) old_nodes: HashSet<String>,
}

/// The nodes inside a controllable unit.
pub(super) struct Nodes {
    pub(super) fan: String,
    pub(super) cooling: String,
    pub(super) heating: String,
}

impl Unit {
    pub(super) fn find(model: &Model, air_loop: &str) -> Result<Self> {
        let fields = model.require("AirLoopHVAC", air_loop)?;
        let demand_inlet = demand_inlet(model, air_loop, fields)?;
        let (branch, component) = unit_component(model, air_loop)?.ok_or_else(|| {
            Error::unsupported("AirLoopHVAC", air_loop, "its branches have no supported unitary system")
        })?;
        let mut old_nodes =
            inner_nodes(model, model.require(&component.object.class, &component.object.name)?)?;
        let (served, followers) = zones_of(model, air_loop)?;
        old_nodes.extend([component.inlet.clone(), component.outlet.clone(), demand_inlet.clone()]);
        Ok(Self {
            air_loop: air_loop.to_owned(),
            branch,
            demand_inlet,
            served,
            followers,
            outdoor_air: OutdoorAir::find(model, &component.inlet),
            old_nodes: old_nodes.iter().map(|node| node.to_lowercase()).collect(),
            component,
        })
    }

    /// The node where the air enters the unit.
    pub(super) fn inlet(&self) -> &str {
        &self.component.inlet
    }

    /// The node where the conditioned air leaves the unit and its coils.
    pub(super) fn outlet(&self) -> &str {
        &self.component.outlet
    }

    /// The error for a unit that cannot be rewritten.
    pub(super) fn unsupported(&self, why: &str) -> Error {
        Error::unsupported(&self.component.object.class, &self.component.object.name, why)
    }
}

/// Returns whether an object class is a unit that can be made controllable.
pub(super) fn is_unit(class: &str) -> bool {
    is_one_of(class, &UNIT_CLASSES)
}

/// Returns the branch and the component of the first unit on an air loop's supply side.
pub(super) fn unit_component(model: &Model, air_loop: &str) -> Result<Option<(String, Component)>> {
    for branch in branches(model, air_loop)? {
        let unit = components(model, &branch)?.into_iter().find(|c| is_unit(&c.object.class));
        if let Some(unit) = unit {
            return Ok(Some((branch, unit)));
        }
    }
    Ok(None)
}

/// Returns the coil that a unit refers to.
pub(super) fn coil(unit: &Fields, which: &str) -> Option<Reference> {
    reference(unit, &format!("{which}_object_type"), &format!("{which}_name"))
}

/// Returns every node of the fan and the coils of a unit.
fn inner_nodes(model: &Model, unit: &Fields) -> Result<Vec<String>> {
    let mut nodes = Vec::new();
    for part in parts(unit) {
        let part = model.require(&part.class, &part.name)?;
        let ends = ["air_inlet_node_name", "air_outlet_node_name"];
        nodes.extend(ends.iter().filter_map(|end| text(part, end)).map(str::to_owned));
    }
    Ok(nodes)
}

/// Returns the node where the air of the unit enters the demand side.
fn demand_inlet(model: &Model, air_loop: &str, fields: &Fields) -> Result<String> {
    let field = required(fields, "AirLoopHVAC", air_loop, "demand_side_inlet_node_names")?;
    match &nodes_of(model, &field)[..] {
        [node] => Ok(node.clone()),
        _ => Err(Error::unsupported(
            "AirLoopHVAC",
            air_loop,
            "it has two ducts to the demand side; one is supported",
        )),
    }
}

/// Returns the zone whose thermostat controls the unit of an air loop, and the other zones.
fn zones_of(model: &Model, air_loop: &str) -> Result<(ServedZone, Vec<ServedZone>)> {
    let mut served = served_zones(model, air_loop)?;
    if served.len() > 1 {
        let Some(control) = served.iter().position(|served| governs(model, &served.zone)) else {
            let zones: Vec<_> = served.iter().map(|served| served.zone.as_str()).collect();
            let why =
                format!("no thermostat of its zones ({}) controls its unitary system", zones.join(", "));
            return Err(Error::unsupported("AirLoopHVAC", air_loop, &why));
        };
        served.swap(0, control);
    }
    let followers = served.split_off(1);
    followers.iter().try_for_each(|follower| require_follower(model, follower))?;
    Ok((served.remove(0), followers))
}

/// Rejects a zone that does not simply share the air of a unit: with a damper or a heater under its own thermostat.
fn require_follower(model: &Model, follower: &ServedZone) -> Result<()> {
    let Reference { class, name } = &follower.terminal;
    if !class.eq_ignore_ascii_case(CONSTANT) {
        let why = format!("one of several terminals on a unitary system; expected {CONSTANT}");
        return Err(Error::unsupported(class, name, &why));
    }
    match zone_equipment(model, &follower.zone)?.iter().find(|item| is_one_of(&item.class, &ZONE_HEATERS)) {
        None => Ok(()),
        Some(heater) => {
            let why =
                "its zone shares the air of a unitary system with another, whose thermostat controls it";
            Err(Error::unsupported(&heater.class, &heater.name, why))
        }
    }
}
