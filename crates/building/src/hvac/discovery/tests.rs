//! What is found in small models.

use std::path::Path;

use serde_json::json;

use super::*;

/// A zone with a unit heater, and one with this equipment beside a unit heater.
fn two_zones(class: &str) -> Model {
    let connections = |zone: &str| json!({"zone_name": zone, "zone_conditioning_equipment_list_name": zone});
    let item =
        |class: &str, name: &str| json!({"zone_equipment_object_type": class, "zone_equipment_name": name});
    let heater = json!({"heating_coil_object_type": "Coil:Heating:Electric", "heating_coil_name": "Coil",
        "availability_schedule_name": "Day"});
    let model = json!({
        "Zone": {"A": {"idf_order": 1}, "B": {"idf_order": 2}},
        "ZoneControl:Thermostat": {
            "TA": {"zone_or_zonelist_name": "A", "control_1_name": "Theirs"},
            "TB": {"zone_or_zonelist_name": "B", "control_1_name": "Theirs"}},
        "ZoneHVAC:EquipmentConnections": {"CA": connections("A"), "CB": connections("B")},
        "ZoneHVAC:EquipmentList": {
            "A": {"equipment": [item("ZoneHVAC:UnitHeater", "HA")]},
            "B": {"equipment": [item(class, "X"), item("ZoneHVAC:UnitHeater", "HB")]}},
        "ZoneHVAC:UnitHeater": {"HA": heater.clone(), "HB": heater},
        "Coil:Heating:Electric": {"Coil": {}},
    });
    Model::from_epjson(&model.to_string(), Path::new("two.epJSON")).unwrap()
}

fn driven(found: &Discovery) -> Vec<&str> {
    found.systems.iter().flat_map(System::zones).collect()
}

#[test]
fn what_cannot_be_driven_is_told_and_keeps_its_thermostat() {
    let mut model = two_zones("ZoneHVAC:PackagedTerminalAirConditioner");
    let found = discover(&mut model, 1.2).unwrap();
    assert_eq!(driven(&found), ["A"]);
    let left: Vec<_> = found.uncontrolled.iter().map(|item| item.object.name.as_str()).collect();
    assert_eq!(left, ["X", "HB"]);
    assert!(
        found.uncontrolled[1].reason.contains("PackagedTerminalAirConditioner"),
        "{}",
        found.uncontrolled[1].reason
    );
    assert_eq!(model.require("ZoneControl:Thermostat", "TB").unwrap()["control_1_name"], "Theirs");
    assert_eq!(model.require("ZoneHVAC:UnitHeater", "HB").unwrap()["availability_schedule_name"], "Day");
    assert_eq!(model.require("ZoneControl:Thermostat", "TA").unwrap()["control_1_name"], "A Dual Setpoint");
    assert!(has_own_controls(&model, "B").unwrap());
}

#[test]
fn ventilation_beside_a_heater_is_left_and_the_heater_driven() {
    let mut model = two_zones("ZoneHVAC:EnergyRecoveryVentilator");
    let found = discover(&mut model, 1.2).unwrap();
    assert_eq!(driven(&found), ["A", "B"]);
    assert_eq!(found.uncontrolled.len(), 1);
    assert!(found.uncontrolled[0].reason.contains("ventilates"), "{}", found.uncontrolled[0].reason);
}

#[test]
fn a_system_that_fails_half_way_leaves_the_model_as_it_was() {
    let mut model = two_zones("Fan:ZoneExhaust");
    // The heater is switched on before its thermostat is found to be missing.
    model.remove("ZoneControl:Thermostat", "TB");
    let before = model.get("ZoneHVAC:UnitHeater", "HB").cloned();
    let found = discover(&mut model, 1.2).unwrap();
    assert_eq!(driven(&found), ["A"]);
    assert_eq!(model.get("ZoneHVAC:UnitHeater", "HB").cloned(), before);
    assert!(
        found.uncontrolled.iter().any(|item| item.reason.contains("no thermostat")),
        "{:?}",
        found.uncontrolled
    );
    assert!(!has_own_controls(&model, "B").unwrap());
}
