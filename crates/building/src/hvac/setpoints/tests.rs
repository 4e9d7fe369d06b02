//! Zones of small models under setpoint control.

use std::path::Path;

use serde_json::{Value, json};

use super::*;
use crate::hvac::KINDS;
use crate::hvac::discovery::{Discovery, Uncontrolled, Unsupported, discover, discover_setpoints};
use crate::model::text;

/// A zone with this equipment under a thermostat that only heats.
fn model(class: &str, more: Value) -> Model {
    let mut model = json!({
        "Zone": {"Z": {}},
        "ZoneControl:Thermostat": {"T": {
            "zone_or_zonelist_name": "Z", "control_type_schedule_name": "Heats",
            "control_1_object_type": "ThermostatSetpoint:SingleHeating", "control_1_name": "Theirs"}},
        "ZoneHVAC:EquipmentConnections": {"C": {
            "zone_name": "Z", "zone_conditioning_equipment_list_name": "L"}},
        "ZoneHVAC:EquipmentList": {"L": {"equipment": [
            {"zone_equipment_object_type": class, "zone_equipment_name": "X"}]}},
        (class): {"X": {}},
    });
    let (all, more) = (model.as_object_mut().unwrap(), more.as_object().unwrap().clone());
    all.extend(more);
    Model::from_epjson(&model.to_string(), Path::new("zone.epJSON")).unwrap()
}

fn found(model: &mut Model) -> Discovery {
    discover(model, 1.2, &KINDS, Unsupported::LeftAlone, &[]).unwrap()
}

/// A terminal of a loop with a cooling coil that follows the thermostat of `control_zone`.
fn terminal(class: &str, control_zone: &str) -> Value {
    json!({
        "ZoneHVAC:AirDistributionUnit": {"X": {"air_terminal_object_type": class, "air_terminal_name": "D"}},
        (class): {"D": {"air_inlet_node_name": "N"}},
        "AirLoopHVAC": {"Loop": {"branch_list_name": "Bs", "demand_side_inlet_node_names": "I"}},
        "BranchList": {"Bs": {"branches": [{"branch_name": "B"}]}},
        "Branch": {"B": {"components": [
            {"component_object_type": "AirLoopHVAC:Unitary:Furnace:HeatCool", "component_name": "F"}]}},
        "AirLoopHVAC:Unitary:Furnace:HeatCool": {"F": {
            "cooling_coil_object_type": "Coil:Cooling:DX:SingleSpeed", "cooling_coil_name": "Cold",
            "controlling_zone_or_thermostat_location": control_zone}},
        "AirLoopHVAC:SupplyPath": {"P": {"supply_air_path_inlet_node_name": "I", "components": [
            {"component_object_type": "AirLoopHVAC:ZoneSplitter", "component_name": "S"}]}},
        "AirLoopHVAC:ZoneSplitter": {"S": {"nodes": [{"outlet_node_name": "N"}]}},
    })
}

const UNIT: &str = "ZoneHVAC:AirDistributionUnit";
const PASSES: &str = "AirTerminal:SingleDuct:ConstantVolume:NoReheat";

#[test]
fn a_zone_gets_both_setpoints_at_every_hour_whatever_its_author_uses() {
    let mut model = model("ZoneHVAC:IdealLoadsAirSystem", json!({}));
    let found = found(&mut model);
    let [system] = &found.systems[..] else { panic!("{found:?}") };
    let quantities: Vec<_> = system.actuators().iter().map(|actuator| actuator.quantity).collect();
    assert_eq!(quantities, [Quantity::HeatingSetpoint, Quantity::CoolingSetpoint]);
    assert_eq!(system.node_type(0), NodeType::SetpointZone);
    assert!(found.uncontrolled.iter().all(|item| item.follows_setpoints), "{:?}", found.uncontrolled);
    let thermostat = model.require("ZoneControl:Thermostat", "T").unwrap();
    assert_eq!(thermostat["control_1_object_type"], "ThermostatSetpoint:DualSetpoint");
}

#[test]
fn a_zone_that_nothing_cools_has_a_heating_setpoint_alone() {
    let mut ideal = model(
        "ZoneHVAC:IdealLoadsAirSystem",
        json!({"ZoneHVAC:IdealLoadsAirSystem": {"X": {"cooling_availability_schedule_name": "Off"}},
            "Schedule:Constant": {"Off": {"hourly_value": 0.0}}}),
    );
    assert_eq!(found(&mut ideal).systems[0].actuators().len(), 1);
    let mut model = model("ZoneHVAC:Baseboard:RadiantConvective:Steam", json!({}));
    let found = found(&mut model);
    assert_eq!(found.systems[0].actuators().len(), 1);
    assert_eq!(found.systems[0].conditioning(), Conditioning::Heating);
    assert_eq!(found.systems[0].node_type(0), NodeType::HeatingOnlyZone);
    let cooling = model.require("Schedule:Constant", "Z Cooling Setpoint").unwrap();
    assert_eq!(cooling["hourly_value"], OUT_OF_REACH, "above every heating setpoint");
}

/// Radiant floors, ventilated slabs and the like.
#[test]
fn equipment_that_holds_its_own_temperatures_is_left_alone_also_beside_what_follows() {
    const FLOOR: &str = "ZoneHVAC:LowTemperatureRadiant:VariableFlow";
    const SLAB: &str = "ZoneHVAC:VentilatedSlab";
    let floor = json!({(FLOOR): {"X": {"design_object": "D"}},
        "ZoneHVAC:LowTemperatureRadiant:VariableFlow:Design": {
            "D": {"heating_control_temperature_schedule_name": "Warm"}}});
    let slab = json!({(SLAB): {"X": {"heating_high_control_temperature_schedule_name": "Warm"}}});
    for (class, more) in [(FLOOR, floor), (SLAB, slab)] {
        let mut alone = model(class, more.clone());
        let mut beside = model(class, more);
        let said = found(&mut alone);
        assert!(said.systems.is_empty());
        let reasons = said.reasons().join("\n");
        assert!(reasons.contains("1 × Zone: ") && reasons.contains("own schedules"), "{reasons}");
        beside.insert("ZoneHVAC:IdealLoadsAirSystem", "Y", json!({}));
        let list = beside.require_mut("ZoneHVAC:EquipmentList", "L").unwrap();
        let ideal =
            json!({"zone_equipment_object_type": "ZoneHVAC:IdealLoadsAirSystem", "zone_equipment_name": "Y"});
        list["equipment"].as_array_mut().unwrap().push(ideal);
        let said = found(&mut beside);
        assert_eq!(said.systems.len(), 1);
        let follows = |item: &Uncontrolled| (item.object.class == class, item.follows_setpoints);
        assert_eq!(said.uncontrolled.iter().map(follows).collect::<Vec<_>>(), [(true, false), (false, true)]);
    }
}

#[test]
fn comfort_control_and_programs_that_set_the_thermostat_give_way() {
    let more = json!({
        "ZoneControl:Thermostat:ThermalComfort": {"Comfort": {"zone_or_zonelist_name": "z"}},
        "EnergyManagementSystem:Actuator": {"A": {
            "actuated_component_type": "Zone Temperature Control", "actuated_component_unique_name": "Z",
            "actuated_component_control_type": "Heating Setpoint"}},
        "EnergyManagementSystem:Program": {"P": {"lines": [{"program_line": "SET A = 25"}]}},
    });
    let mut model = model("ZoneHVAC:IdealLoadsAirSystem", more);
    model.remove("ZoneControl:Thermostat", "T");
    let found = found(&mut model);
    assert_eq!(found.systems.len(), 1);
    assert!(found.notes[0].contains("ThermalComfort `Comfort`"), "{:?}", found.notes);
    assert!(model.objects("ZoneControl:Thermostat:ThermalComfort").is_empty());
    assert!(model.objects("EnergyManagementSystem:Program").is_empty());
    assert_eq!(model.names("ZoneControl:Thermostat"), ["Z Thermostat"]);
}

/// An EMS program reads the setpoint of two zones.
#[test]
fn programs_that_read_a_setpoint_read_the_commanded_one() {
    let more = json!({
        "Zone": {"Z": {}, "Y": {}},
        "ThermostatSetpoint:SingleHeating": {"Theirs": {"setpoint_temperature_schedule_name": "Day"}},
        "EnergyManagementSystem:Sensor": {"S": {
            "output_variable_or_output_meter_index_key_name": "DAY",
            "output_variable_or_output_meter_name": "Schedule Value"}},
    });
    let mut alone = model("ZoneHVAC:IdealLoadsAirSystem", more);
    let read = |model: &Model| {
        let sensor = model.require("EnergyManagementSystem:Sensor", "S").unwrap();
        text(sensor, "output_variable_or_output_meter_index_key_name").unwrap().to_owned()
    };
    let mut shared = alone.clone();
    assert_eq!(found(&mut alone).notes, [""; 0]);
    assert_eq!(read(&alone), "Z Heating Setpoint");

    for (class, from, to) in
        [("ZoneControl:Thermostat", "T", "TY"), ("ZoneHVAC:EquipmentConnections", "C", "CY")]
    {
        let mut own = shared.require(class, from).unwrap().clone();
        let field = if from == "T" { "zone_or_zonelist_name" } else { "zone_name" };
        own.insert(field.into(), "Y".into());
        shared.insert(class, to, Value::Object(own));
    }
    let notes = found(&mut shared).notes;
    let [note] = &notes[..] else { panic!("{notes:?}") };
    assert_eq!(read(&shared), "Y Heating Setpoint");
    for word in ["`S`", "`Day`", "the setpoint of `Y` now, not of `Z`"] {
        assert!(note.to_lowercase().contains(&word.to_lowercase()), "{note}");
    }
}

#[test]
fn a_zone_on_a_unit_that_follows_another_zone_is_reported_as_uncontrolled() {
    for (terminal_class, control_zone, controlled) in
        [(PASSES, "Other", 0), (PASSES, "Z", 1), ("AirTerminal:SingleDuct:VAV:NoReheat", "Other", 1)]
    {
        let mut model = model(UNIT, terminal(terminal_class, control_zone));
        let found = discover_setpoints(&mut model, 1.2).unwrap();
        assert_eq!(found.systems.len(), controlled, "{terminal_class} {control_zone}");
        for system in &found.systems {
            assert_eq!(system.actuators().len(), 2, "the loop cools");
        }
        let said: Vec<_> = found.uncontrolled.iter().map(|item| item.reason.as_str()).collect();
        assert_eq!(said.len(), 1 - controlled);
        assert!(said.iter().all(|reason| reason.contains("`Loop`")), "{said:?}");
    }
}

#[test]
fn setpoints_stay_half_a_kelvin_apart() {
    assert_eq!(separate(21.0, 24.0), 24.0);
    assert_eq!(separate(24.0, 21.0), 24.5);
    assert_eq!(separate(21.0, 21.25), 21.5);
    assert_eq!(around(21.0), [20.75, 21.25]);
    let [heating, cooling] = around(21.0);
    assert_eq!(separate(heating, cooling), cooling);
}
