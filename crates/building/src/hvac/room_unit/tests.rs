//! Tests of how a room unit is made controllable.

use std::path::Path;

use serde_json::json;

use super::*;
use crate::hvac::Quantity;
use crate::hvac::distribution::served_zones;
use crate::hvac::references::nodes_of;
use crate::model::text;

/// A fan coil with outdoor air in a room with an exhaust fan.
fn fan_coil() -> Model {
    let text = json!({
        "Zone": {"Room": {}},
        "ZoneControl:Thermostat": {"T": {"zone_or_zonelist_name": "Room"}},
        "ZoneHVAC:EquipmentConnections": {"C": {
            "zone_name": "Room", "zone_conditioning_equipment_list_name": "List",
            "zone_air_inlet_node_or_nodelist_name": "Supply",
            "zone_air_exhaust_node_or_nodelist_name": "Exhausts"}},
        "NodeList": {"Exhausts": {"nodes": [{"node_name": "To Unit"}, {"node_name": "To Fan"}]}},
        "ZoneHVAC:EquipmentList": {"List": {"equipment": [
            {"zone_equipment_object_type": "ZoneHVAC:FourPipeFanCoil", "zone_equipment_name": "FC",
             "zone_equipment_cooling_sequence": 1}]}},
        "ZoneHVAC:FourPipeFanCoil": {"FC": {
            "air_inlet_node_name": "To Unit", "air_outlet_node_name": "Supply",
            "maximum_supply_air_flow_rate": 0.3, "maximum_outdoor_air_flow_rate": 0.05,
            "outdoor_air_schedule_name": "Day",
            "outdoor_air_mixer_object_type": "OutdoorAir:Mixer", "outdoor_air_mixer_name": "Mixer",
            "supply_air_fan_object_type": "Fan:ConstantVolume", "supply_air_fan_name": "Fan",
            "cooling_coil_object_type": "Coil:Cooling:Water", "cooling_coil_name": "Cool",
            "heating_coil_object_type": "Coil:Heating:Water", "heating_coil_name": "Heat"}},
        "Schedule:Constant": {"Day": {"hourly_value": 1.0}},
        "OutdoorAir:Mixer": {"Mixer": {
            "mixed_air_node_name": "Mixed", "outdoor_air_stream_node_name": "Outside",
            "relief_air_stream_node_name": "Relief", "return_air_stream_node_name": "To Unit"}},
        "Fan:ConstantVolume": {"Fan": {
            "maximum_flow_rate": 0.4, "pressure_rise": 75.0,
            "air_inlet_node_name": "Mixed", "air_outlet_node_name": "A"}},
        "Coil:Cooling:Water": {"Cool": {"air_inlet_node_name": "A", "air_outlet_node_name": "B"}},
        "Coil:Heating:Water": {"Heat": {"air_inlet_node_name": "B", "air_outlet_node_name": "Supply"}},
    });
    Model::from_epjson(&text.to_string(), Path::new("fan_coil.epJSON")).unwrap()
}

fn edit(model: &mut Model) -> Result<RoomUnit> {
    let object = Reference { class: UNITS[2].to_owned(), name: "FC".to_owned() };
    RoomUnit::make_controllable(model, Candidate::Equipment { zone: "Room", object: &object }, 1.2)
}

#[test]
fn a_fan_coil_becomes_a_unitary_system_on_its_own_air_loop() {
    let mut model = fan_coil();
    let system = edit(&mut model).unwrap();
    let [served] = &served_zones(&model, "FC Air Loop").unwrap()[..] else { panic!("one zone") };
    assert_eq!((served.zone.as_str(), served.unit.as_str()), ("Room", "FC Air Loop Distribution"));
    let quantities = system.actuators().iter().map(|actuator| actuator.quantity).collect::<Vec<_>>();
    assert_eq!(quantities, [Quantity::SupplyAirFlow, Quantity::SupplyAirTemperature]);
    // The unit uses 0.3 of the 0.4 m³/s of its fan.
    assert!((system.unit.flow.high - 0.3 * 1.2).abs() < 1e-12);
    assert!((system.ventilation().unwrap().min_outdoor_air - 0.05 * 1.2).abs() < 1e-12);
    let unit = model.require("AirLoopHVAC:UnitarySystem", "FC").unwrap();
    assert_eq!(text(unit, "air_inlet_node_name"), Some("Mixed"));
    assert_eq!(text(unit, "cooling_coil_object_type"), Some("Coil:Cooling:Water"));
    assert_eq!(text(unit, "heating_coil_object_type"), Some("Coil:Heating:Water"));
    assert!(model.names("ZoneHVAC:FourPipeFanCoil").is_empty());
}

#[test]
fn the_room_returns_air_to_the_loop_and_keeps_its_exhaust_fan() {
    let mut model = fan_coil();
    edit(&mut model).unwrap();
    let connections = model.require("ZoneHVAC:EquipmentConnections", "C").unwrap();
    assert_eq!(text(connections, "zone_air_exhaust_node_or_nodelist_name"), Some("To Fan"));
    assert_eq!(text(connections, "zone_return_air_node_or_nodelist_name"), Some("FC Air Loop Zone Return"));
    let air_loop = model.require("AirLoopHVAC", "FC Air Loop").unwrap();
    assert_eq!(text(air_loop, "supply_side_inlet_node_name"), Some("To Unit"));
}

#[test]
fn a_room_with_dedicated_outdoor_air_returns_air_to_both_loops() {
    let mut model = fan_coil();
    let connections = model.require_mut("ZoneHVAC:EquipmentConnections", "C").unwrap();
    connections.insert("zone_return_air_node_or_nodelist_name".into(), json!("To Outdoor Air"));
    let nodes = json!({"outlet_node_name": "X", "nodes": [{"inlet_node_name": "to outdoor air"}]});
    model.insert("AirLoopHVAC:ZoneMixer", "Outdoor Air Mixer", nodes);
    edit(&mut model).unwrap();
    let connections = model.require("ZoneHVAC:EquipmentConnections", "C").unwrap();
    let list = text(connections, "zone_return_air_node_or_nodelist_name").unwrap();
    assert_eq!(nodes_of(&model, list), ["To Outdoor Air", "FC Air Loop Zone Return"]);
}

#[test]
fn the_outdoor_air_schedule_becomes_the_damper_s_schedule() {
    let mut model = fan_coil();
    let system = edit(&mut model).unwrap();
    let damper = system.ventilation().unwrap().damper.as_ref().unwrap();
    assert_eq!(model.require(&damper.component, &damper.key).unwrap()["hourly_value"], 1.0);
    let controller = model.require("Controller:OutdoorAir", "FC Air Loop Outdoor Air").unwrap();
    assert_eq!(controller["minimum_outdoor_air_schedule_name"], damper.key);
}

#[test]
fn a_unit_whose_nodes_are_not_its_zone_s_is_refused_by_name() {
    for (field, why) in [
        ("zone_air_inlet_node_or_nodelist_name", "not an inlet node of its zone"),
        ("zone_air_exhaust_node_or_nodelist_name", "not an exhaust node of its zone"),
    ] {
        let mut model = fan_coil();
        model.require_mut("ZoneHVAC:EquipmentConnections", "C").unwrap().insert(field.into(), json!("Other"));
        let error = edit(&mut model).unwrap_err().to_string();
        assert!(error.contains("`FC`") && error.contains(why), "{error}");
    }
}

#[test]
fn a_unit_without_outdoor_air_has_no_mixer() {
    let mut model = fan_coil();
    let fields = model.require_mut("ZoneHVAC:FourPipeFanCoil", "FC").unwrap();
    fields.insert("maximum_outdoor_air_flow_rate".into(), json!(0.0));
    let system = edit(&mut model).unwrap();
    assert_eq!(system.ventilation(), None);
    for class in ["AirLoopHVAC:OutdoorAirSystem", "OutdoorAir:Mixer"] {
        assert!(model.names(class).is_empty(), "{class}");
    }
}

#[test]
fn a_unit_with_more_than_60_air_changes_per_hour_is_refused() {
    let mut model = fan_coil();
    let zone = model.require_mut("Zone", "Room").unwrap();
    zone.insert("volume".into(), json!(0.3 * 60.0 + 1.0));
    assert!(edit(&mut model.clone()).is_ok());
    model.require_mut("Zone", "Room").unwrap().insert("volume".into(), json!(0.3 * 60.0 - 1.0));
    let error = edit(&mut model).unwrap_err().to_string();
    assert!(error.contains("`FC`") && error.contains("64 times an hour"), "{error}");
}
