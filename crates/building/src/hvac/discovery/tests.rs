//! Discovery in small models.

use std::path::Path;

use serde_json::json;

use super::*;
use crate::hvac::KINDS;
use crate::hvac::energy_management::PROGRAM;

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

fn left_alone(model: &mut Model) -> Discovery {
    discover(model, 1.2, &KINDS, Unsupported::LeftAlone, &[]).unwrap()
}

fn driven(found: &Discovery) -> Vec<&str> {
    found.systems.iter().flat_map(|system| system.zones()).collect()
}

#[test]
fn unsupported_equipment_is_reported_and_follows_the_setpoints_of_its_zone() {
    let mut model = two_zones("ZoneHVAC:WindowAirConditioner");
    let found = left_alone(&mut model);
    assert_eq!(driven(&found), ["A", "B"]);
    assert_eq!(found.systems[1].kind().id, "setpoints");
    assert!(found.uncontrolled.iter().all(|item| item.follows_setpoints));
    let left: Vec<_> = found.uncontrolled.iter().map(|item| item.object.name.as_str()).collect();
    assert_eq!(left, ["X", "HB"]);
    assert!(
        found.uncontrolled[1].reason.contains("WindowAirConditioner"),
        "{}",
        found.uncontrolled[1].reason
    );
    assert_eq!(model.require("ZoneControl:Thermostat", "TB").unwrap()["control_1_name"], "B Dual Setpoint");
    assert_eq!(model.require("ZoneHVAC:UnitHeater", "HB").unwrap()["availability_schedule_name"], "Day");
    assert_eq!(model.require("ZoneControl:Thermostat", "TA").unwrap()["control_1_name"], "A Dual Setpoint");
    assert!(has_own_controls(&model, "B").unwrap());
}

#[test]
fn a_heater_beside_ventilation_is_controlled() {
    let mut model = two_zones("ZoneHVAC:EnergyRecoveryVentilator");
    let found = left_alone(&mut model);
    assert_eq!(driven(&found), ["A", "B"]);
    assert_eq!(found.uncontrolled.len(), 1);
    assert!(found.uncontrolled[0].reason.contains("ventilates"), "{}", found.uncontrolled[0].reason);
}

#[test]
fn a_failed_edit_does_not_change_the_model() {
    let mut model = two_zones("Fan:ZoneExhaust");
    // The heater is switched on before its thermostat is found to be missing.
    model.remove("ZoneControl:Thermostat", "TB");
    let before = model.get("ZoneHVAC:UnitHeater", "HB").cloned();
    let found = left_alone(&mut model);
    assert_eq!(driven(&found), ["A"]);
    assert_eq!(model.get("ZoneHVAC:UnitHeater", "HB").cloned(), before);
    assert!(
        found.uncontrolled.iter().any(|item| item.reason.contains("no thermostat")),
        "{:?}",
        found.uncontrolled
    );
    assert!(!has_own_controls(&model, "B").unwrap());
}

#[test]
fn unsupported_equipment_is_rejected_by_name_where_all_systems_are_to_be_controlled() {
    let mut model = two_zones("ZoneHVAC:UnitVentilator");
    let error = discover(&mut model, 1.2, &KINDS, Unsupported::Refused, &[]).unwrap_err().to_string();
    for word in ["ZoneHVAC:UnitVentilator", "`X`", "`B`"] {
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn an_exhaust_fan_is_not_controlled_and_not_reported_where_all_systems_are_controlled() {
    let mut model = two_zones("Fan:ZoneExhaust");
    let found = discover(&mut model, 1.2, &KINDS, Unsupported::Refused, &[]).unwrap();
    assert_eq!(driven(&found), ["A", "B"]);
    assert_eq!(found.uncontrolled, []);
}

#[test]
fn both_ways_of_discovery_control_the_same_systems_in_the_same_model() {
    let [mut refused, mut left_alone] = [two_zones("Fan:ZoneExhaust"), two_zones("Fan:ZoneExhaust")];
    let strict = discover(&mut refused, 1.2, &KINDS, Unsupported::Refused, &[]).unwrap();
    let tolerant = discover(&mut left_alone, 1.2, &KINDS, Unsupported::LeftAlone, &[]).unwrap();
    assert_eq!(strict.systems, tolerant.systems);
    assert_eq!(refused.to_epjson(), left_alone.to_epjson());
}

#[test]
fn systems_are_read_back_as_they_were_written_and_an_unknown_kind_is_named() {
    let found = left_alone(&mut two_zones("Fan:ZoneExhaust"));
    let written = serde_json::to_value(&found.systems).unwrap();
    assert_eq!(written[0]["heating_only"]["zone"], "A");
    let read: Vec<Box<dyn System>> = serde_json::from_value(written.clone()).unwrap();
    assert_eq!(read, found.systems);
    assert!(*read[0] != *read[1]);
    let unknown = json!([{"geothermal": written[0]["heating_only"]}]);
    let said = serde_json::from_value::<Vec<Box<dyn System>>>(unknown).unwrap_err().to_string();
    assert!(said.contains("`geothermal`"), "{said}");
}

/// The model of [`two_zones`] with this equipment in its second zone.
fn room_with(equipment: &[&str]) -> Model {
    let mut model = two_zones("Fan:ZoneExhaust");
    let item = |(number, class): (usize, &&str)| json!({"zone_equipment_object_type": class, "zone_equipment_name": format!("E{number}")});
    let list: Vec<_> = equipment.iter().enumerate().map(item).collect();
    model.require_mut("ZoneHVAC:EquipmentList", "B").unwrap().insert("equipment".into(), list.into());
    for (number, class) in equipment.iter().enumerate() {
        let heater = model.require("ZoneHVAC:UnitHeater", "HB").unwrap().clone();
        model.insert(class, &format!("E{number}"), Value::Object(heater));
    }
    model
}

#[test]
fn equipment_that_is_off_all_year_does_not_prevent_the_control_of_other_equipment() {
    const IDEAL: &str = "ZoneHVAC:IdealLoadsAirSystem";
    let classes = [IDEAL, "ZoneHVAC:UnitHeater"];
    let kinds = |absent: &[Reference]| {
        let mut model = room_with(&classes);
        let found = discover(&mut model, 1.2, &KINDS, Unsupported::LeftAlone, absent).unwrap();
        (found.systems[1].kind().id, found.uncontrolled)
    };
    assert_eq!(kinds(&[]).0, "setpoints");
    let ideal = Reference { class: IDEAL.into(), name: "E0".into() };
    let (kind, uncontrolled) = kinds(std::slice::from_ref(&ideal));
    assert_eq!(kind, "heating_only");
    let [left] = &uncontrolled[..] else { panic!("{uncontrolled:?}") };
    assert!(left.object == ideal && left.reason.contains("0 all year"), "{left:?}");
}

/// Programs that act on a heater's zone and on its coil, one of them also on lights.
#[test]
fn programs_that_act_on_a_heater_are_removed_and_reported_with_what_else_they_set() {
    const ACTUATOR: &str = "EnergyManagementSystem:Actuator";
    let mut model = two_zones("Fan:ZoneExhaust");
    let mut actuator = |name: &str, [class, what, of]: [&str; 3]| {
        let fields = json!({"actuated_component_type": class, "actuated_component_control_type": what,
            "actuated_component_unique_name": of});
        model.insert(ACTUATOR, name, fields);
    };
    actuator("Heat_A", ["Zone Temperature Control", "Heating Setpoint", "a"]);
    actuator("Coil_Off", ["Coil", "Capacity", "coil"]);
    actuator("Lamp", ["Lights", "Electricity Rate", "A"]);
    for (name, line) in [("P", "SET Heat_A = 12"), ("Q", "SET Coil_Off = 0"), ("R", "SET Lamp = 0")] {
        let lines = if name == "P" { vec![line, "SET Lamp = 1"] } else { vec![line] };
        let lines: Vec<_> = lines.iter().map(|line| json!({"program_line": line})).collect();
        model.insert(PROGRAM, name, json!({"lines": lines}));
    }
    let found = left_alone(&mut model);
    assert_eq!((model.names(PROGRAM), model.names(ACTUATOR)), (vec!["R".into()], vec!["Lamp".into()]));
    let expected = [
        "removed EMS program `P`, which set Heating Setpoint of `a`, and with it what it sets of others: \
         Electricity Rate of `A`",
        "removed EMS program `Q`, which set Capacity of `coil`",
    ];
    assert_eq!(found.notes, expected);
}
