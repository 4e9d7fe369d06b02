//! Rooms with an exhaust fan: kitchen and dining room.
//!
//! The hood replaces the air of the kitchen every three minutes. Air that its unit does not supply infiltrates from
//! outdoors, so in cold weather the temperature swings by tens of kelvin with the supply flow: the prototype in
//! Fairbanks is between 11 and 27 °C under any feedback control at 5-minute steps, and warm-up days do not converge.

use b2b_building::hvac::zone_equipment::zone_equipment;
use b2b_building::model::{number, text};
use b2b_building::{Model, Result};
use serde_json::json;

/// Minimum ratio of the design flow of the room's unit to the fan's: enough to replace the exhaust air, with a margin.
const SUPPLY_OVER_EXHAUST: f64 = 1.25;
/// Ratio of the heat capacity of furnishings (ovens, fryers, counters, tables) to the heat capacity of the air.
/// Engineering judgment, near the 7 of a furnished house; the prototypes have only wooden slabs, which are too thick to
/// follow.
const CAPACITY_OVER_AIR: f64 = 6.0;
/// Convergence tolerances of warm-up days, K and fraction of load: the widest that the engine accepts.
const WARMUP_TOLERANCE: f64 = 0.5;

/// Gives rooms with an exhaust fan a unit large enough to replace the exhaust air, and the thermal mass of their
/// furnishings.
///
/// # Errors
/// [`b2b_building::Error::MissingObject`] for a dangling reference.
pub(super) fn settle(model: &mut Model) -> Result<()> {
    let rooms = exhausted_rooms(model)?;
    for room in &rooms {
        supply_what_is_exhausted(model, room)?;
        furnish(model, &room.zone);
    }
    if !rooms.is_empty() {
        tolerate_unlike_days(model);
    }
    Ok(())
}

/// A zone with an exhaust fan.
struct Room {
    zone: String,
    /// Its `Sizing:Zone`.
    sizing: String,
    /// Flow of the fan, m³/s.
    exhaust: f64,
}

const SIZING: &str = "Sizing:Zone";

fn exhausted_rooms(model: &Model) -> Result<Vec<Room>> {
    let mut rooms = Vec::new();
    for (sizing, fields) in model.objects(SIZING) {
        let zone = text(fields, "zone_or_zonelist_name").unwrap_or_default();
        let equipment = zone_equipment(model, zone)?;
        let fans = equipment.iter().filter(|e| e.class.eq_ignore_ascii_case("Fan:ZoneExhaust"));
        let flows = fans.filter_map(|fan| number(model.get(&fan.class, &fan.name)?, "maximum_flow_rate"));
        let exhaust: f64 = flows.sum();
        if exhaust > 0.0 {
            rooms.push(Room { zone: zone.to_owned(), sizing: sizing.to_owned(), exhaust });
        }
    }
    Ok(rooms)
}

fn supply_what_is_exhausted(model: &mut Model, room: &Room) -> Result<()> {
    let fields = model.require_mut(SIZING, &room.sizing)?;
    let shipped = number(fields, "cooling_minimum_air_flow").unwrap_or_default();
    let minimum = shipped.max(SUPPLY_OVER_EXHAUST * room.exhaust);
    fields.insert("cooling_minimum_air_flow".into(), json!(minimum));
    fields.insert("cooling_design_air_flow_method".into(), "DesignDayWithLimit".into());
    Ok(())
}

fn furnish(model: &mut Model, zone: &str) {
    let multipliers = json!({
        "zone_or_zonelist_name": zone,
        "temperature_capacity_multiplier": CAPACITY_OVER_AIR,
        "humidity_capacity_multiplier": 1.0,
        "carbon_dioxide_capacity_multiplier": 1.0,
        "generic_contaminant_capacity_multiplier": 1.0,
    });
    model.insert("ZoneCapacitanceMultiplier:ResearchSpecial", &format!("{zone} Mass"), multipliers);
}

fn tolerate_unlike_days(model: &mut Model) {
    for name in model.names("Building") {
        if let Some(building) = model.get_mut("Building", &name) {
            for quantity in ["temperature", "loads"] {
                building.insert(format!("{quantity}_convergence_tolerance_value"), json!(WARMUP_TOLERANCE));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Model {
        let mut model = Model::default();
        for (zone, fan) in [("Kitchen", "Fan:ZoneExhaust"), ("Shop", "ZoneHVAC:UnitHeater")] {
            let sizing = json!({"zone_or_zonelist_name": zone, "cooling_minimum_air_flow": 1.0});
            model.insert(SIZING, zone, sizing);
            let connections = json!({"zone_name": zone, "zone_conditioning_equipment_list_name": zone});
            model.insert("ZoneHVAC:EquipmentConnections", zone, connections);
            let equipment = json!([{"zone_equipment_object_type": fan, "zone_equipment_name": "Hood"}]);
            model.insert("ZoneHVAC:EquipmentList", zone, json!({"equipment": equipment}));
        }
        model.insert("Fan:ZoneExhaust", "Hood", json!({"maximum_flow_rate": 2.0}));
        model
    }

    #[test]
    fn the_unit_of_a_kitchen_can_replace_its_exhaust_air() {
        let mut model = model();
        settle(&mut model).unwrap();
        assert_eq!(model.get(SIZING, "Kitchen").unwrap()["cooling_minimum_air_flow"], 2.5);
        assert_eq!(model.get(SIZING, "Shop").unwrap()["cooling_minimum_air_flow"], 1.0);
    }

    #[test]
    fn only_a_kitchen_is_furnished() {
        let mut model = model();
        settle(&mut model).unwrap();
        assert_eq!(model.names("ZoneCapacitanceMultiplier:ResearchSpecial"), ["Kitchen Mass"]);
    }
}
