//! The edits on a rooftop unit.

use std::path::Path;

use serde_json::{Value, json};

use super::cooling_coil::{CURVES, PART_LOAD_CURVE};
use super::unit::CONSTANT;
use super::*;
use crate::hvac::schedules::ALWAYS_ON;
use crate::hvac::system::System as _;
use crate::model::{items, text};
use crate::morphology::universe::NodeType;

/// A rooftop unit with a multi-speed coil, draw-through, on a zone with a constant-volume terminal.
fn rooftop() -> Model {
    let mut model = air_handler();
    model.as_object_mut().unwrap().extend(demand_side());
    Model::from_epjson(&model.to_string(), Path::new("rooftop.epJSON")).unwrap()
}

fn cooling_coil() -> Value {
    let curves = |speed: &str| {
        CURVES
            .iter()
            .chain([&PART_LOAD_CURVE])
            .map(|c| (format!("{speed}{c}"), json!(format!("curve {c}"))))
            .collect::<serde_json::Map<_, _>>()
    };
    let mut cooling = json!({
        "air_inlet_node_name": "Mixed", "air_outlet_node_name": "After cooling",
        "speed_1_gross_rated_total_cooling_capacity": 5000.0, "speed_2_gross_rated_total_cooling_capacity": 10000.0,
        "speed_1_rated_air_flow_rate": 0.3, "speed_2_rated_air_flow_rate": 0.5,
        "speed_1_gross_rated_cooling_cop": 4.0, "speed_2_gross_rated_cooling_cop": 3.8,
        "speed_1_gross_rated_sensible_heat_ratio": 0.8, "speed_2_gross_rated_sensible_heat_ratio": 0.75,
    });
    for (key, value) in curves("speed_2_") {
        cooling[key] = value;
    }
    cooling
}

fn air_handler() -> Value {
    json!({
        "AirLoopHVAC": {"Loop": {
            "branch_list_name": "Branches", "demand_side_inlet_node_names": "Demand inlet",
            "supply_side_outlet_node_names": "Supply outlet"}},
        "BranchList": {"Branches": {"branches": [{"branch_name": "Main"}]}},
        "Branch": {"Main": {"components": [
            {"component_object_type": "AirLoopHVAC:OutdoorAirSystem", "component_name": "OA",
             "component_inlet_node_name": "Return", "component_outlet_node_name": "Mixed"},
            {"component_object_type": "AirLoopHVAC:UnitarySystem", "component_name": "Unit",
             "component_inlet_node_name": "Mixed", "component_outlet_node_name": "Supply outlet"}]}},
        "AirLoopHVAC:OutdoorAirSystem": {"OA": {}},
        "AirLoopHVAC:UnitarySystem": {"Unit": {
            "control_type": "Load", "fan_placement": "DrawThrough",
            "controlling_zone_or_thermostat_location": "Zone",
            "supply_fan_object_type": "Fan:SystemModel", "supply_fan_name": "Fan",
            "cooling_coil_object_type": "Coil:Cooling:DX:MultiSpeed", "cooling_coil_name": "Cooling",
            "heating_coil_object_type": "Coil:Heating:Fuel", "heating_coil_name": "Heating",
            "design_specification_multispeed_object_type": "UnitarySystemPerformance:Multispeed",
            "design_specification_multispeed_object_name": "Speeds"}},
        "UnitarySystemPerformance:Multispeed": {"Speeds": {}},
        "Fan:SystemModel": {"Fan": {
            "air_inlet_node_name": "After heating", "air_outlet_node_name": "Supply outlet",
            "availability_schedule_name": "Office hours", "design_maximum_air_flow_rate": 0.6,
            "fan_total_efficiency": 0.58, "design_pressure_rise": 622.5, "motor_efficiency": 0.9,
            "motor_in_air_stream_fraction": 1.0}},
        "Coil:Cooling:DX:MultiSpeed": {"Cooling": cooling_coil()},
        "Coil:Heating:Fuel": {"Heating": {
            "air_inlet_node_name": "After cooling", "air_outlet_node_name": "After heating",
            "nominal_capacity": 20000.0}},
        "SetpointManager:SingleZone:Cooling": {"Old": {"setpoint_node_or_nodelist_name": "Supply outlet"}},
        "SetpointManager:MixedAir": {"Old mixed": {"setpoint_node_or_nodelist_name": "After cooling"}},
        "SetpointManager:Scheduled": {"Hot water": {"setpoint_node_or_nodelist_name": "Plant outlet"}},
        "Controller:OutdoorAir": {"OA control": {
            "economizer_control_type": "DifferentialDryBulb",
            "mixed_air_node_name": "Mixed", "maximum_fraction_of_outdoor_air_schedule_name": "0.75"}},
    })
}

fn demand_side() -> serde_json::Map<String, Value> {
    let objects = json!({
        "ZoneHVAC:EquipmentConnections": {"C": {
            "zone_name": "Zone", "zone_conditioning_equipment_list_name": "Equipment"}},
        "ZoneHVAC:EquipmentList": {"Equipment": {"equipment": [{
            "zone_equipment_object_type": "ZoneHVAC:AirDistributionUnit", "zone_equipment_name": "ADU"}]}},
        "ZoneHVAC:AirDistributionUnit": {"ADU": {
            "air_terminal_object_type": "AirTerminal:SingleDuct:ConstantVolume:NoReheat",
            "air_terminal_name": "Terminal"}},
        "AirTerminal:SingleDuct:ConstantVolume:NoReheat": {"Terminal": {
            "air_inlet_node_name": "Terminal inlet", "air_outlet_node_name": "Zone inlet",
            "maximum_air_flow_rate": 0.5}},
        "Zone": {"Zone": {}},
        "AirLoopHVAC:SupplyPath": {"Path": {
            "supply_air_path_inlet_node_name": "Demand inlet",
            "components": [{"component_object_type": "AirLoopHVAC:ZoneSplitter",
                "component_name": "Splitter"}]}},
        "AirLoopHVAC:ZoneSplitter": {"Splitter": {"nodes": [{"outlet_node_name": "Terminal inlet"}]}},
        "ZoneControl:Thermostat": {"T": {"zone_or_zonelist_name": "Zone"}},
    });
    objects.as_object().unwrap().clone()
}

/// The same as a heat pump with an electric backup, without an economizer.
fn heat_pump() -> Model {
    let mut model = rooftop();
    model.replace_references("Coil:Heating:Fuel", "Coil:Heating:DX:SingleSpeed");
    let coil = model.remove("Coil:Heating:Fuel", "Heating").unwrap();
    model.insert("Coil:Heating:DX:SingleSpeed", "Heating", Value::Object(coil));
    model.insert("Coil:Heating:Electric", "Backup", json!({}));
    let unit = model.require_mut("AirLoopHVAC:UnitarySystem", "Unit").unwrap();
    unit.insert("supplemental_heating_coil_object_type".into(), json!("Coil:Heating:Electric"));
    unit.insert("supplemental_heating_coil_name".into(), json!("Backup"));
    without_economizer(&mut model);
    model
}

fn without_economizer(model: &mut Model) {
    model.require_mut("Controller:OutdoorAir", "OA control").unwrap().remove("economizer_control_type");
}

/// Class, inlet and outlet of what is on the branch.
fn on_branch(model: &Model) -> Vec<[&str; 3]> {
    let ends = ["component_object_type", "component_inlet_node_name", "component_outlet_node_name"];
    let items = items(model.require("Branch", "Main").unwrap(), "components");
    items.map(|item| ends.map(|end| text(item, end).unwrap())).collect()
}

fn controllable() -> (Model, Unitary) {
    let mut model = rooftop();
    let unit = make_controllable(&mut model, "Loop", 1.2).unwrap();
    (model, unit)
}

#[test]
fn the_flow_bound_is_the_design_flow_of_the_terminal_in_kg_s() {
    let (_, unit) = controllable();
    assert_eq!(unit.flow.high, 0.5 * 1.2);
    assert_eq!(unit.flow.high * unit.flow.scale, 1.0, "the engine takes a fraction");
    assert_eq!(unit.flow.effect.key, "Zone inlet");
    assert_eq!(unit.supply_temperature.effect.key, "Supply outlet");
}

#[test]
fn the_unit_follows_a_setpoint_and_blows_through() {
    let (model, _) = controllable();
    let unit = model.require("AirLoopHVAC:UnitarySystem", "Unit").unwrap();
    assert_eq!(unit["control_type"], "SetPoint");
    assert_eq!(unit["fan_placement"], "BlowThrough");
    assert!(model.objects("UnitarySystemPerformance:Multispeed").is_empty());
    let air = [
        ("Fan:VariableVolume", "Fan", "Mixed", "Loop Fan Outlet"),
        ("Coil:Cooling:DX:TwoSpeed", "Cooling", "Loop Fan Outlet", "Loop Cooling Coil Outlet"),
        ("Coil:Heating:Fuel", "Heating", "Loop Cooling Coil Outlet", "Supply outlet"),
    ];
    for (class, name, inlet, outlet) in air {
        let part = model.require(class, name).unwrap();
        assert_eq!(part["air_inlet_node_name"], inlet, "{class}");
        assert_eq!(part["air_outlet_node_name"], outlet, "{class}");
        assert_eq!(part["availability_schedule_name"], ALWAYS_ON, "{class}");
    }
}

#[test]
fn the_fan_keeps_its_pressure_and_efficiency_without_a_minimum_flow() {
    let (model, _) = controllable();
    let fan = model.require("Fan:VariableVolume", "Fan").unwrap();
    assert_eq!(fan["pressure_rise"], 622.5);
    assert_eq!(fan["fan_total_efficiency"], 0.58);
    assert_eq!(fan["maximum_flow_rate"], 0.6);
    assert_eq!(fan["fan_power_minimum_flow_fraction"], 0.0);
}

#[test]
fn a_multi_speed_coil_keeps_the_performance_of_both_speeds() {
    let (model, _) = controllable();
    let coil = model.require("Coil:Cooling:DX:TwoSpeed", "Cooling").unwrap();
    assert_eq!(coil["high_speed_gross_rated_total_cooling_capacity"], 10000.0);
    assert_eq!(coil["low_speed_gross_rated_total_cooling_capacity"], 5000.0);
    assert_eq!(coil["low_speed_rated_air_flow_rate"], 0.3);
    assert_eq!(coil["high_speed_gross_rated_cooling_cop"], 3.8);
}

#[test]
fn only_one_scheduled_setpoint_remains_on_the_unit() {
    let (model, unit) = controllable();
    assert!(model.objects("SetpointManager:SingleZone:Cooling").is_empty());
    assert_eq!(model.names("SetpointManager:MixedAir"), ["Loop Mixed Air Setpoint"]);
    assert!(model.contains("SetpointManager:Scheduled", "Hot water"));
    let manager = model.require("SetpointManager:Scheduled", "Loop Supply Setpoint").unwrap();
    assert_eq!(manager["schedule_name"], unit.supply_temperature.key.as_str());
    let nodes = &model.require("NodeList", "Loop Setpoint Nodes").unwrap()["nodes"];
    let names: Vec<_> = nodes.as_array().unwrap().iter().map(|n| n["node_name"].clone()).collect();
    assert_eq!(names, ["Loop Cooling Coil Outlet", "Supply outlet", "Demand inlet"]);
}

#[test]
fn the_minimum_flow_of_the_terminal_is_the_command() {
    let (model, unit) = controllable();
    let terminal = model.require("AirTerminal:SingleDuct:VAV:NoReheat", "Terminal").unwrap();
    assert_eq!(terminal["minimum_air_flow_fraction_schedule_name"], unit.flow.key.as_str());
    let unit = model.require("ZoneHVAC:AirDistributionUnit", "ADU").unwrap();
    assert_eq!(unit["air_terminal_object_type"], "AirTerminal:SingleDuct:VAV:NoReheat");
}

/// The rooftop unit with a second zone, `Annex`, on its splitter.
fn rooftop_of_two() -> Model {
    let mut model = rooftop();
    let annex = json!({
        "ZoneHVAC:EquipmentConnections": {"zone_name": "Annex", "zone_conditioning_equipment_list_name": "Annex"},
        "ZoneHVAC:EquipmentList": {"equipment": [{
            "zone_equipment_object_type": "ZoneHVAC:AirDistributionUnit", "zone_equipment_name": "Annex"}]},
        "ZoneHVAC:AirDistributionUnit": {"air_terminal_object_type": CONSTANT, "air_terminal_name": "Annex"},
        CONSTANT: {"air_inlet_node_name": "Annex terminal", "air_outlet_node_name": "Annex inlet",
            "maximum_air_flow_rate": 0.1},
        "Zone": {"idf_order": 0},
        "ZoneControl:Thermostat": {"zone_or_zonelist_name": "Annex"},
    });
    for (class, fields) in annex.as_object().unwrap() {
        model.insert(class, "Annex", fields.clone());
    }
    let splitter = model.require_mut("AirLoopHVAC:ZoneSplitter", "Splitter").unwrap();
    splitter["nodes"].as_array_mut().unwrap().push(json!({"outlet_node_name": "Annex terminal"}));
    model
}

#[test]
fn a_unit_of_two_zones_gives_both_the_same_share_of_their_design_flows() {
    let mut model = rooftop_of_two();
    let unit = make_controllable(&mut model, "Loop", 1.2).unwrap();
    assert_eq!(unit.zones(), ["Zone", "Annex"], "the zone with the thermostat is first");
    assert_eq!(unit.zones_with_loops(), 1);
    assert!((unit.flow.high - 1.2 * (0.5 + 0.1)).abs() < 1e-12, "{}", unit.flow.high);
    assert_eq!(
        unit.flow.effect.key, unit.supply_temperature.effect.key,
        "the flow at the outlet of the unit"
    );
    for terminal in ["Terminal", "Annex"] {
        let fields = model.require("AirTerminal:SingleDuct:VAV:NoReheat", terminal).unwrap();
        assert_eq!(fields["minimum_air_flow_fraction_schedule_name"], supply_air_flow_fraction("Zone"));
    }
    let cooling = model.require("Schedule:Constant", "Annex Cooling Setpoint").unwrap();
    assert_eq!(cooling["hourly_value"], OUT_OF_REACH, "no load of the annex moves its terminal");
    assert_eq!([0, 1].map(|zone| unit.node_type(zone)), [NodeType::UnitaryZone, NodeType::FollowingZone]);
}

#[test]
fn zones_of_a_unit_with_dampers_or_heaters_of_their_own_are_named() {
    let refused = |edit: fn(&mut Model)| {
        let mut model = rooftop_of_two();
        edit(&mut model);
        make_controllable(&mut model, "Loop", 1.2).unwrap_err().to_string()
    };
    let deaf = refused(|model| {
        let unit = model.require_mut("AirLoopHVAC:UnitarySystem", "Unit").unwrap();
        unit.remove("controlling_zone_or_thermostat_location");
    });
    assert!(deaf.contains("no thermostat of its zones (Annex, Zone)"), "{deaf}");
    let damper = refused(|model| {
        model.replace_references(CONSTANT, "AirTerminal:SingleDuct:VAV:NoReheat");
        let fields = model.remove(CONSTANT, "Annex").unwrap();
        model.insert("AirTerminal:SingleDuct:VAV:NoReheat", "Annex", Value::Object(fields));
        let fields = model.remove(CONSTANT, "Terminal").unwrap();
        model.insert("AirTerminal:SingleDuct:VAV:NoReheat", "Terminal", Value::Object(fields));
    });
    assert!(damper.contains("`Annex`") && damper.contains("expected AirTerminal"), "{damper}");
    let heated = refused(|model| {
        let list = model.require_mut("ZoneHVAC:EquipmentList", "Annex").unwrap();
        list["equipment"].as_array_mut().unwrap().push(json!({"zone_equipment_name": "Baseboard",
            "zone_equipment_object_type": "ZoneHVAC:Baseboard:Convective:Electric"}));
    });
    assert!(heated.contains("`Baseboard`"), "{heated}");
}

#[test]
fn outdoor_air_may_be_all_of_the_supply() {
    let (model, _) = controllable();
    let controller = model.require("Controller:OutdoorAir", "OA control").unwrap();
    assert!(!controller.contains_key("maximum_fraction_of_outdoor_air_schedule_name"));
}

#[test]
fn making_it_controllable_again_changes_nothing() {
    let (mut model, unit) = controllable();
    let before = model.clone();
    assert_eq!(make_controllable(&mut model, "Loop", 1.2).unwrap(), unit);
    assert_eq!(model, before);
}

#[test]
fn a_coil_that_cannot_be_rewritten_is_named() {
    let mut model = rooftop();
    model.replace_references("Coil:Cooling:DX:MultiSpeed", "Coil:Cooling:DX:VariableSpeed");
    let coil = model.remove("Coil:Cooling:DX:MultiSpeed", "Cooling").unwrap();
    model.insert("Coil:Cooling:DX:VariableSpeed", "Cooling", Value::Object(coil));
    let error = make_controllable(&mut model, "Loop", 1.2).unwrap_err().to_string();
    assert!(error.contains("Coil:Cooling:DX:VariableSpeed") && error.contains("`Cooling`"), "{error}");
}

/// The model of a unit with its parts on the branch instead: cooling coil in a coil system, heating coils and fan.
fn in_parts(mut model: Model, heating: &[[&str; 2]]) -> Model {
    model.remove("AirLoopHVAC:UnitarySystem", "Unit");
    model.remove("UnitarySystemPerformance:Multispeed", "Speeds");
    let system =
        json!({"cooling_coil_object_type": "Coil:Cooling:DX:MultiSpeed", "cooling_coil_name": "Cooling"});
    model.insert("CoilSystem:Cooling:DX", "Cooling system", system);
    let mut inlet = "Mixed".to_owned();
    let mut part = |[class, name]: [&str; 2], outlet: &str| {
        json!({"component_object_type": class, "component_name": name,
            "component_inlet_node_name": std::mem::replace(&mut inlet, outlet.into()),
            "component_outlet_node_name": outlet})
    };
    let outdoor_air = json!({"component_object_type": "AirLoopHVAC:OutdoorAirSystem", "component_name": "OA",
        "component_inlet_node_name": "Return", "component_outlet_node_name": "Mixed"});
    let mut components =
        vec![outdoor_air, part(["CoilSystem:Cooling:DX", "Cooling system"], "After cooling")];
    components.extend(heating.iter().map(|coil| part(*coil, &format!("After {}", coil[1]))));
    components.push(part(["Fan:SystemModel", "Fan"], "Supply outlet"));
    model.require_mut("Branch", "Main").unwrap()["components"] = json!(components);
    model
}

#[test]
fn a_unit_in_parts_is_rewritten_as_the_same_packaged_unit() {
    let mut model = in_parts(rooftop(), &[["Coil:Heating:Fuel", "Heating"]]);
    assert!(has_unit(&model, "Loop").unwrap());
    let unit = make_controllable(&mut model, "Loop", 1.2).unwrap();
    let (whole, same) = controllable();
    assert_eq!(unit, same);
    assert!(model.objects("CoilSystem:Cooling:DX").is_empty());
    for (class, name) in [
        ("Fan:VariableVolume", "Fan"),
        ("Coil:Cooling:DX:TwoSpeed", "Cooling"),
        ("Coil:Heating:Fuel", "Heating"),
    ] {
        assert_eq!(model.get(class, name), whole.get(class, name), "{class}");
    }
    assert_eq!(on_branch(&model), on_branch(&whole));
}

#[test]
fn a_heat_pump_in_parts_is_rewritten_as_the_same_heat_pump() {
    let parts = [["CoilSystem:Heating:DX", "Heating system"], ["Coil:Heating:Electric", "Backup"]];
    let mut model = in_parts(heat_pump(), &parts);
    let system =
        json!({"heating_coil_object_type": "Coil:Heating:DX:SingleSpeed", "heating_coil_name": "Heating"});
    model.insert("CoilSystem:Heating:DX", "Heating system", system);
    let mut whole = heat_pump();
    let [unit, same] = [&mut model, &mut whole].map(|m| make_controllable(m, "Loop", 1.2).unwrap());
    assert_eq!(unit, same);
    assert_eq!(on_branch(&model), on_branch(&whole));
    for (class, name) in [("Coil:Heating:DX:SingleSpeed", "Heating"), ("Coil:Heating:Electric", "Backup")] {
        assert_eq!(model.get(class, name), whole.get(class, name), "{class}");
    }
}

#[test]
fn the_mixer_has_a_setpoint_only_for_an_economizer() {
    let mut model = rooftop();
    without_economizer(&mut model);
    make_controllable(&mut model, "Loop", 1.2).unwrap();
    assert!(model.objects("SetpointManager:MixedAir").is_empty());
}

#[test]
fn the_coils_of_a_heat_pump_are_downstream_of_the_unit_with_its_setpoint() {
    let mut model = heat_pump();
    let unit = make_controllable(&mut model, "Loop", 1.2).unwrap();
    assert_eq!(
        on_branch(&model),
        [
            ["AirLoopHVAC:OutdoorAirSystem", "Return", "Mixed"],
            ["AirLoopHVAC:UnitarySystem", "Mixed", "Loop Cooling Coil Outlet"],
            ["CoilSystem:Heating:DX", "Loop Cooling Coil Outlet", "Loop Heating Coil Outlet"],
            ["Coil:Heating:Electric", "Loop Heating Coil Outlet", "Supply outlet"],
        ]
    );
    let whole = model.require("AirLoopHVAC:UnitarySystem", "Unit").unwrap();
    assert!(whole.keys().all(|field| !field.contains("heating_coil")), "{whole:?}");
    assert_eq!(whole["air_outlet_node_name"], "Loop Cooling Coil Outlet");
    let backup = model.require("Coil:Heating:Electric", "Backup").unwrap();
    assert_eq!(backup["temperature_setpoint_node_name"], "Supply outlet");
    let nodes = model.require("NodeList", "Loop Setpoint Nodes").unwrap()["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), 4, "after each coil, and where the duct begins");

    let before = model.clone();
    assert_eq!(make_controllable(&mut model, "Loop", 1.2).unwrap(), unit, "again");
    assert_eq!(model, before);
}

#[test]
fn a_heat_pump_with_an_economizer_keeps_its_coils() {
    let mut model = heat_pump();
    let controller = model.require_mut("Controller:OutdoorAir", "OA control").unwrap();
    controller.insert("economizer_control_type".into(), json!("FixedDryBulb"));
    make_controllable(&mut model, "Loop", 1.2).unwrap();
    assert!(model.objects("CoilSystem:Heating:DX").is_empty());
    let unit = model.require("AirLoopHVAC:UnitarySystem", "Unit").unwrap();
    assert_eq!(unit["heating_coil_name"], "Heating");
    assert_eq!(unit["supplemental_heating_coil_name"], "Backup");
}

#[test]
fn a_furnace_becomes_a_unitary_system() {
    let mut model = rooftop();
    let mut unit = model.remove("AirLoopHVAC:UnitarySystem", "Unit").unwrap();
    unit.retain(|field, _| !field.contains("multispeed"));
    model.insert("AirLoopHVAC:Unitary:Furnace:HeatCool", "Unit", Value::Object(unit));
    let branch = model.require_mut("Branch", "Main").unwrap();
    branch["components"][1]["component_object_type"] = "AirLoopHVAC:Unitary:Furnace:HeatCool".into();
    make_controllable(&mut model, "Loop", 1.2).unwrap();
    assert_eq!(on_branch(&model)[1], ["AirLoopHVAC:UnitarySystem", "Mixed", "Supply outlet"]);
    assert!(model.objects("AirLoopHVAC:Unitary:Furnace:HeatCool").is_empty());
}
