//! Equipment of zones.

use serde_json::{Value, json};

use super::references::{Reference, is_one_of, reference};
use crate::Result;
use crate::model::{Fields, Model, items, text};

/// Heaters of a zone that follow its thermostat.
pub(in crate::hvac) const HEATERS: [&str; 5] = [
    "ZoneHVAC:UnitHeater",
    "ZoneHVAC:Baseboard:Convective:Electric",
    "ZoneHVAC:Baseboard:Convective:Water",
    "ZoneHVAC:Baseboard:RadiantConvective:Electric",
    "ZoneHVAC:Baseboard:RadiantConvective:Water",
];
const LIST: &str = "ZoneHVAC:EquipmentList";
/// The fields of the sequence numbers of equipment.
const SEQUENCES: [&str; 2] =
    ["zone_equipment_cooling_sequence", "zone_equipment_heating_or_no_load_sequence"];
/// Exhaust fan of a zone.
const EXHAUST: &str = "Fan:ZoneExhaust";
/// The terminal of an air loop, as equipment of its zone.
pub(in crate::hvac) const DISTRIBUTION: &str = "ZoneHVAC:AirDistributionUnit";
/// Zone equipment that moves air without controlling a temperature.
pub(in crate::hvac) const VENTILATION: [&str; 2] = [EXHAUST, "ZoneHVAC:EnergyRecoveryVentilator"];
/// Zone equipment of generated buildings that is not controlled: exhaust fans follow their schedules, and the radiant
/// heater of the warehouse is switched off in the prototype.
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
    let Some(list) = list_of(model, zone) else { return Ok(Vec::new()) };
    Ok(items(model.require(LIST, &list)?, "equipment")
        .filter_map(|item| reference(item, "zone_equipment_object_type", "zone_equipment_name"))
        .collect())
}

/// Puts equipment of a zone ahead of all others except exhaust fans, and heaters, which deliver no more than the load.
/// If another delivers warm air first, the engine sees a cooling load and adds flow to the terminal: the more, the
/// nearer its supply air is to the zone's temperature.
///
/// # Errors
/// [`crate::Error::MissingObject`] when the equipment list that the zone names is not in the model.
pub(in crate::hvac) fn put_first(model: &mut Model, zone: &str, first: &str) -> Result<()> {
    let Some(list) = list_of(model, zone) else { return Ok(()) };
    let fields = model.require_mut(LIST, &list)?;
    let Some(equipment) = fields.get_mut("equipment").and_then(Value::as_array_mut) else { return Ok(()) };
    for sequence in SEQUENCES {
        let turn = |item: &Value| item[sequence].as_u64().filter(|&turn| turn > 0);
        let is_first = |item: &Value| named(item, "zone_equipment_name").eq_ignore_ascii_case(first);
        let Some(own) = equipment.iter().find(|item| is_first(item)).and_then(turn) else { continue };
        let gives = |item: &&Value| {
            let class = named(item, "zone_equipment_object_type");
            ![&HEATERS[..], &UNCONTROLLED].iter().any(|classes| is_one_of(class, classes))
        };
        let earliest = equipment.iter().filter(gives).filter_map(turn).min().unwrap_or(own);
        for item in equipment.iter_mut() {
            match turn(item) {
                _ if is_first(item) => item[sequence] = json!(earliest),
                Some(turn) if (earliest..own).contains(&turn) => item[sequence] = json!(turn + 1),
                _ => {}
            }
        }
    }
    Ok(())
}

/// Returns the name in a field of an item; empty without one.
fn named<'a>(item: &'a Value, field: &str) -> &'a str {
    item[field].as_str().unwrap_or_default()
}

/// Returns the name of the equipment list of a zone.
fn list_of(model: &Model, zone: &str) -> Option<String> {
    let mut connections = model.objects("ZoneHVAC:EquipmentConnections").into_iter();
    let is_of_zone =
        |fields: &Fields| text(fields, "zone_name").is_some_and(|z| z.eq_ignore_ascii_case(zone));
    let (_, fields) = connections.find(|(_, fields)| is_of_zone(fields))?;
    Some(text(fields, "zone_conditioning_equipment_list_name").unwrap_or_default().to_owned())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the sequence numbers of the equipment of a zone after the terminal `Own` was put first.
    fn turns(equipment: &[(&str, &str, u64)]) -> Vec<u64> {
        let item = |&(class, name, turn): &(&str, &str, u64)| json!({"zone_equipment_object_type": class, "zone_equipment_name": name, SEQUENCES[0]: turn});
        let model = json!({
            "ZoneHVAC:EquipmentConnections": {"C": {"zone_name": "Z", "zone_conditioning_equipment_list_name": "L"}},
            LIST: {"L": {"equipment": equipment.iter().map(item).collect::<Vec<_>>()}},
        });
        let mut model = Model::from_epjson(&model.to_string(), "t.epJSON".as_ref()).unwrap();
        put_first(&mut model, "Z", "OWN").unwrap();
        items(model.require(LIST, "L").unwrap(), "equipment")
            .map(|item| item[SEQUENCES[0]].as_u64().unwrap())
            .collect()
    }

    #[test]
    fn a_commanded_terminal_comes_before_the_air_of_others() {
        let (own, other) = ((DISTRIBUTION, "Own", 3), (DISTRIBUTION, "Outdoor Air", 1));
        assert_eq!(turns(&[other, (VENTILATION[1], "ERV", 2), own]), [2, 3, 1]);
        assert_eq!(turns(&[(EXHAUST, "Fan", 1), (HEATERS[1], "Heater", 2), own]), [1, 2, 3]);
        assert_eq!(
            turns(&[(HEATERS[1], "Heater", 1), (DISTRIBUTION, "Own", 2), (DISTRIBUTION, "Other", 3)]),
            [1, 2, 3]
        );
        assert_eq!(turns(&[(DISTRIBUTION, "Own", 0), other]), [0, 1], "it has no turn");
    }
}
