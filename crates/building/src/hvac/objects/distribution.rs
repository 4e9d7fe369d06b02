//! The demand side of air loops: their terminals and zones.

use std::collections::HashSet;

use super::references::{Reference, nodes_of};
use crate::model::{Fields, Model, items, text};
use crate::{Error, Result};

/// A terminal on the demand side of an air loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ServedZone {
    /// The zone it serves.
    pub(crate) zone: String,
    /// Its `ZoneHVAC:AirDistributionUnit`.
    pub(crate) unit: String,
    /// The terminal itself.
    pub(crate) terminal: Reference,
}

/// Returns the terminals of an air loop, each with its zone, in model order of the zones.
///
/// # Errors
/// [`crate::Error::Unsupported`] when there is none, or one that no zone has; [`crate::Error::MissingObject`] for
/// a dangling reference.
pub(crate) fn served_zones(model: &Model, air_loop: &str) -> Result<Vec<ServedZone>> {
    let nodes = terminal_nodes(model, air_loop)?;
    let mut served = Vec::new();
    for (unit, fields) in model.objects("ZoneHVAC:AirDistributionUnit") {
        let field = |field| text(fields, field).unwrap_or_default().to_owned();
        let terminal =
            Reference { class: field("air_terminal_object_type"), name: field("air_terminal_name") };
        let inlet = inlet(model.require(&terminal.class, &terminal.name)?);
        if inlet.is_some_and(|node| nodes.contains(&node.to_lowercase())) {
            served.push(ServedZone { zone: zone_of(model, unit)?, unit: unit.to_owned(), terminal });
        }
    }
    let zones = model.names("Zone");
    served.sort_by_key(|s| zones.iter().position(|z| z.eq_ignore_ascii_case(&s.zone)));
    if served.is_empty() {
        return Err(Error::unsupported("AirLoopHVAC", air_loop, "its supply path has no terminal"));
    }
    Ok(served)
}

fn inlet(terminal: &Fields) -> Option<&str> {
    ["air_inlet_node_name", "air_inlet_node", "primary_air_inlet_node_name", "supply_air_inlet_node_name"]
        .into_iter()
        .find_map(|field| text(terminal, field))
}

/// Returns the nodes at the end of a loop's supply path, in lower case.
fn terminal_nodes(model: &Model, air_loop: &str) -> Result<HashSet<String>> {
    let fields = model.require("AirLoopHVAC", air_loop)?;
    let inlet = text(fields, "demand_side_inlet_node_names").unwrap_or_default();
    let inlets = nodes_of(model, inlet);
    let mut nodes = HashSet::new();
    for (_, path) in model.objects("AirLoopHVAC:SupplyPath") {
        let start = text(path, "supply_air_path_inlet_node_name").unwrap_or_default();
        if !inlets.iter().any(|node| node.eq_ignore_ascii_case(start)) {
            continue;
        }
        for item in items(path, "components") {
            let field = |field| text(item, field).unwrap_or_default();
            let splitter = model.require(field("component_object_type"), field("component_name"))?;
            let outlets = items(splitter, "nodes").filter_map(|node| text(node, "outlet_node_name"));
            nodes.extend(outlets.map(str::to_lowercase));
        }
    }
    Ok(nodes)
}

/// Returns the zone that an air distribution unit serves.
fn zone_of(model: &Model, unit: &str) -> Result<String> {
    let is = |name: Option<&str>, other: &str| name.is_some_and(|name| name.eq_ignore_ascii_case(other));
    let lists_unit =
        |list: &Fields| items(list, "equipment").any(|item| is(text(item, "zone_equipment_name"), unit));
    let lists = model.objects("ZoneHVAC:EquipmentList").into_iter().filter(|(_, list)| lists_unit(list));
    lists
        .flat_map(|(list, _)| {
            model
                .objects("ZoneHVAC:EquipmentConnections")
                .into_iter()
                .filter(move |(_, zone)| is(text(zone, "zone_conditioning_equipment_list_name"), list))
        })
        .find_map(|(_, zone)| text(zone, "zone_name"))
        .map(str::to_owned)
        .ok_or_else(|| {
            Error::unsupported("ZoneHVAC:AirDistributionUnit", unit, "no zone has it in its equipment list")
        })
}
