//! Equipment of zones.

use super::references::{Reference, reference};
use crate::Result;
use crate::model::{Model, items, text};

/// Returns the equipment of a zone, in the order of its equipment list; empty for a zone without equipment.
///
/// # Errors
/// [`crate::Error::MissingObject`] when the equipment list that the zone names is not in the model.
pub fn zone_equipment(model: &Model, zone: &str) -> Result<Vec<Reference>> {
    let connections = model
        .objects("ZoneHVAC:EquipmentConnections")
        .into_iter()
        .find(|(_, fields)| text(fields, "zone_name").is_some_and(|z| z.eq_ignore_ascii_case(zone)));
    let Some((_, connections)) = connections else { return Ok(Vec::new()) };
    let list = text(connections, "zone_conditioning_equipment_list_name").unwrap_or_default();
    Ok(items(model.require("ZoneHVAC:EquipmentList", list)?, "equipment")
        .filter_map(|item| reference(item, "zone_equipment_object_type", "zone_equipment_name"))
        .collect())
}
