//! Equipment of zones.

use super::references::{Reference, is_one_of, reference};
use crate::Result;
use crate::model::{Model, items, text};

/// Heaters of a zone that follow its thermostat.
pub(in crate::hvac) const HEATERS: [&str; 5] = [
    "ZoneHVAC:UnitHeater",
    "ZoneHVAC:Baseboard:Convective:Electric",
    "ZoneHVAC:Baseboard:Convective:Water",
    "ZoneHVAC:Baseboard:RadiantConvective:Electric",
    "ZoneHVAC:Baseboard:RadiantConvective:Water",
];
/// Exhaust fan of a zone.
const EXHAUST: &str = "Fan:ZoneExhaust";
/// The terminal of an air loop, as equipment of its zone.
pub(in crate::hvac) const DISTRIBUTION: &str = "ZoneHVAC:AirDistributionUnit";
/// Zone equipment that moves air without controlling a temperature.
pub(in crate::hvac) const VENTILATION: [&str; 2] = [EXHAUST, "ZoneHVAC:EnergyRecoveryVentilator"];
/// Zone equipment of generated buildings that is not controlled: exhaust fans follow their schedules, and the radiant heater
/// of the warehouse is switched off in the prototype.
pub(in crate::hvac) const UNCONTROLLED: [&str; 2] = [EXHAUST, "ZoneHVAC:HighTemperatureRadiant"];

/// Returns whether equipment may share a zone with a controlled system.
pub(in crate::hvac) fn is_beside(class: &str) -> bool {
    [&VENTILATION[..], &UNCONTROLLED, &HEATERS].iter().any(|classes| is_one_of(class, classes))
}

/// Returns whether equipment is the terminal of an air loop.
pub(in crate::hvac) fn is_distribution(class: &str) -> bool {
    class.eq_ignore_ascii_case(DISTRIBUTION)
}

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

/// Returns the design flow of the exhaust fans in some zones, m³/s.
pub(in crate::hvac) fn exhaust_flow(model: &Model, zones: &[String]) -> Result<f64> {
    let mut flow = 0.0;
    for zone in zones {
        for fan in zone_equipment(model, zone)?.iter().filter(|e| is_one_of(&e.class, &[EXHAUST])) {
            flow += model.require_size(EXHAUST, &fan.name, "maximum_flow_rate")?;
        }
    }
    Ok(flow)
}

/// Returns whether a zone has exhaust fans.
///
/// # Errors
/// As [`zone_equipment`].
pub fn has_exhaust(model: &Model, zone: &str) -> Result<bool> {
    Ok(zone_equipment(model, zone)?.iter().any(|equipment| is_one_of(&equipment.class, &[EXHAUST])))
}
