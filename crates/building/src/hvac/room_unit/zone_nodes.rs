//! The nodes of a zone, where its equipment takes and delivers air.

use serde_json::{Value, json};

use crate::hvac::references::{Reference, nodes_of};
use crate::model::{Fields, items, text};
use crate::{Error, Model, Result};

const CONNECTIONS: &str = "ZoneHVAC:EquipmentConnections";
const INLETS: &str = "zone_air_inlet_node_or_nodelist_name";
const EXHAUSTS: &str = "zone_air_exhaust_node_or_nodelist_name";
const RETURNS: &str = "zone_return_air_node_or_nodelist_name";

/// The connections of a zone to its equipment.
pub(super) struct ZoneNodes {
    connections: String,
    fields: Fields,
}

impl ZoneNodes {
    /// Finds the connections of a zone.
    pub(super) fn find(model: &Model, zone: &str) -> Result<Self> {
        let is_own =
            |fields: &Fields| text(fields, "zone_name").is_some_and(|name| name.eq_ignore_ascii_case(zone));
        let found = model.objects(CONNECTIONS).into_iter().find(|(_, fields)| is_own(fields));
        let (name, fields) =
            found.ok_or_else(|| Error::unsupported("Zone", zone, "it has no equipment connections"))?;
        Ok(Self { connections: name.to_owned(), fields: fields.clone() })
    }

    /// Returns whether a node delivers air to the zone.
    pub(super) fn delivers(&self, model: &Model, node: &str) -> bool {
        self.has(model, INLETS, node)
    }

    /// Returns the nodes through which the zone returns air to air loops, such as dedicated outdoor air.
    fn returns(&self, model: &Model) -> Vec<String> {
        let returns = text(&self.fields, RETURNS).map(|nodes| nodes_of(model, nodes)).unwrap_or_default();
        let mixers = model.objects("AirLoopHVAC:ZoneMixer").into_iter();
        let collectors: Vec<_> = mixers.chain(model.objects("AirLoopHVAC:ReturnPlenum")).collect();
        let is_collected = |node: &String| {
            let is_own =
                |other: &Fields| text(other, "inlet_node_name").is_some_and(|n| n.eq_ignore_ascii_case(node));
            collectors.iter().any(|(_, fields)| items(fields, "nodes").any(is_own))
        };
        returns.into_iter().filter(is_collected).collect()
    }

    /// Returns whether a node takes air from the zone.
    pub(super) fn takes(&self, model: &Model, node: &str) -> bool {
        self.has(model, EXHAUSTS, node)
    }

    fn has(&self, model: &Model, field: &str, node: &str) -> bool {
        let nodes = text(&self.fields, field).map(|nodes| nodes_of(model, nodes)).unwrap_or_default();
        nodes.iter().any(|other| other.eq_ignore_ascii_case(node))
    }

    /// Replaces a node that takes air from the zone with a return node.
    pub(super) fn return_through(&self, model: &mut Model, exhaust: &str, node: &str) -> Result<()> {
        let exhausts = text(&self.fields, EXHAUSTS).unwrap_or_default();
        let mut kept = nodes_of(model, exhausts);
        kept.retain(|other| !other.eq_ignore_ascii_case(exhaust));
        let mut returns = self.returns(model);
        returns.push(node.to_owned());
        self.set(model, EXHAUSTS, &kept, exhausts)?;
        self.set(model, RETURNS, &returns, &format!("{node} List"))
    }

    /// Sets the nodes of a field, in a list of this name if there are several.
    fn set(&self, model: &mut Model, field: &str, nodes: &[String], list: &str) -> Result<()> {
        let fields = model.require_mut(CONNECTIONS, &self.connections)?;
        match nodes {
            [] => _ = fields.remove(field),
            [only] => _ = fields.insert(field.into(), json!(only)),
            several => {
                fields.insert(field.into(), json!(list));
                let nodes: Vec<Value> = several.iter().map(|node| json!({"node_name": node})).collect();
                model.insert("NodeList", list, json!({"nodes": nodes}));
            }
        }
        Ok(())
    }

    /// Puts other equipment in the place of equipment of the zone.
    pub(super) fn replace(&self, model: &mut Model, old: &Reference, new: &Reference) -> Result<()> {
        let list = text(&self.fields, "zone_conditioning_equipment_list_name").unwrap_or_default();
        let fields = model.require_mut("ZoneHVAC:EquipmentList", list)?;
        let equipment = fields.get_mut("equipment").and_then(Value::as_array_mut);
        for item in equipment.into_iter().flatten() {
            let is_old =
                item["zone_equipment_name"].as_str().is_some_and(|name| old.name.eq_ignore_ascii_case(name));
            if is_old {
                item["zone_equipment_object_type"] = json!(new.class);
                item["zone_equipment_name"] = json!(new.name);
            }
        }
        Ok(())
    }
}
