use std::path::Path;

use serde_json::{Value, json};

use super::components::{AIR_SPECIFIC_HEAT, DX_COOLING, OUTDOOR_AIR_SYSTEM, WATER_HEATING};
use super::supply_temperature::{HEATING_COIL_RISE, NEUTRAL_SUPPLY_TEMPERATURE};
use super::terminal::{NO_REHEAT, REHEAT};
use super::*;
use crate::hvac::schedules::ALWAYS_ON;
use crate::hvac::system::System as _;
use crate::hvac::thermostat::OUT_OF_REACH;
use crate::model::{items, number, text};
use crate::morphology::universe::NodeType;

const DENSITY: f64 = 1.2;

/// One loop, draw-through, with two terminals whose zones come in the other order.
fn office() -> Model {
    let model = json!({
        "AirLoopHVAC": {"L": {
            "branch_list_name": "LB", "demand_side_inlet_node_names": "demand",
            "supply_side_outlet_node_names": "supply"}},
        "BranchList": {"LB": {"branches": [{"branch_name": "Main"}]}},
        "Branch": {"Main": {"components": [
            component(OUTDOOR_AIR_SYSTEM, "OA", "return", "mixed"),
            component(DX_COOLING, "Cool", "mixed", "cold"),
            component("Coil:Heating:Fuel", "Heat", "cold", "warm"),
            component("Fan:VariableVolume", "Fan", "warm", "supply")]}},
        OUTDOOR_AIR_SYSTEM: {"OA": {"controller_list_name": "OA List"}},
        "AirLoopHVAC:ControllerList": {"OA List": {
            "controller_1_object_type": "Controller:OutdoorAir", "controller_1_name": "OA Controller"}},
        "Controller:OutdoorAir": {"OA Controller": {
            "actuator_node_name": "outside", "economizer_control_type": "DifferentialDryBulb"}},
        DX_COOLING: {"Cool": {
            "dx_cooling_coil_system_inlet_node_name": "mixed", "dx_cooling_coil_system_outlet_node_name": "cold",
            "dx_cooling_coil_system_sensor_node_name": "COLD", "cooling_coil_name": "DX",
            "cooling_coil_object_type": "Coil:Cooling:DX:TwoSpeed"}},
        "Coil:Cooling:DX:TwoSpeed": {"DX": {"air_inlet_node_name": "mixed", "air_outlet_node_name": "cold"}},
        "Coil:Heating:Fuel": {"Heat": {
            "air_inlet_node_name": "cold", "air_outlet_node_name": "warm", "nominal_capacity": 100.0,
            "temperature_setpoint_node_name": "warm"}},
        "Fan:VariableVolume": {"Fan": {
            "air_inlet_node_name": "warm", "air_outlet_node_name": "supply", "maximum_flow_rate": 2.0}},
        "SetpointManager:MixedAir": {"M": {"setpoint_node_or_nodelist_name": "Cold Nodes"}},
        "SetpointManager:OutdoorAirReset": {"R": {"setpoint_node_or_nodelist_name": "SUPPLY"}},
        "SetpointManager:Scheduled": {"Hot Water": {"setpoint_node_or_nodelist_name": "hot water"}},
        "NodeList": {"Cold Nodes": {"nodes": [{"node_name": "cold"}]}},
        "AirLoopHVAC:SupplyPath": {"P": {"supply_air_path_inlet_node_name": "demand", "components": [{
            "component_object_type": "AirLoopHVAC:ZoneSplitter", "component_name": "S"}]}},
        "AirLoopHVAC:ZoneSplitter": {"S": {"nodes": [
            {"outlet_node_name": "b in"}, {"outlet_node_name": "a in"}]}},
        "Zone": {"A": {"idf_order": 1}, "B": {"idf_order": 2}},
    });
    let mut model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
    for (zone, order) in [("B", 1), ("A", 2)] {
        add_terminal(&mut model, zone, order);
    }
    model
}

fn component(class: &str, name: &str, inlet: &str, outlet: &str) -> Value {
    json!({"component_object_type": class, "component_name": name,
        "component_inlet_node_name": inlet, "component_outlet_node_name": outlet})
}

fn add_terminal(model: &mut Model, zone: &str, order: u32) {
    let name = |what: &str| format!("{zone} {what}");
    let fields = json!({
        "air_inlet_node_name": name("in"), "maximum_air_flow_rate": 1.5, "damper_heating_action": "Reverse",
        "constant_minimum_air_flow_fraction": 0.3, "zone_minimum_air_flow_input_method": "Constant",
        "reheat_coil_object_type": "Coil:Heating:Electric", "reheat_coil_name": name("Coil")});
    model.insert(REHEAT, &name("Box"), fields);
    model.insert("Coil:Heating:Electric", &name("Coil"), json!({"availability_schedule_name": "Day"}));
    let unit =
        json!({"idf_order": order, "air_terminal_object_type": REHEAT, "air_terminal_name": name("Box")});
    model.insert("ZoneHVAC:AirDistributionUnit", &name("Unit"), unit);
    let list = json!({"equipment": [{"zone_equipment_name": name("Unit"),
        "zone_equipment_object_type": "ZoneHVAC:AirDistributionUnit"}]});
    model.insert("ZoneHVAC:EquipmentList", &name("List"), list);
    let connections = json!({"zone_name": zone, "zone_conditioning_equipment_list_name": name("List")});
    model.insert("ZoneHVAC:EquipmentConnections", &name("Connections"), connections);
    model.insert("ZoneControl:Thermostat", &name("Thermostat"), json!({"zone_or_zonelist_name": zone}));
}

fn field<'a>(model: &'a Model, class: &str, name: &str, field: &str) -> &'a str {
    text(model.require(class, name).unwrap(), field).unwrap()
}

#[test]
fn the_fan_blows_through_the_coils_and_every_node_moves_with_its_component() {
    let mut model = office();
    make_controllable(&mut model, "L", DENSITY).unwrap();
    let branch = model.require("Branch", "Main").unwrap();
    let chain: Vec<_> = items(branch, "components")
        .map(|item| {
            ["component_name", "component_inlet_node_name", "component_outlet_node_name"]
                .map(|f| text(item, f).unwrap())
        })
        .collect();
    let expected = [
        ["OA", "return", "mixed"],
        ["Fan", "mixed", "Fan Outlet Node"],
        ["Cool", "Fan Outlet Node", "Cool Outlet Node"],
        ["Heat", "Cool Outlet Node", "supply"],
    ];
    assert_eq!(chain, expected);
    assert_eq!(field(&model, "Fan:VariableVolume", "Fan", "air_inlet_node_name"), "mixed");
    let coil = "Coil:Cooling:DX:TwoSpeed";
    assert_eq!(field(&model, coil, "DX", "air_inlet_node_name"), "Fan Outlet Node");
    assert_eq!(field(&model, coil, "DX", "air_outlet_node_name"), "Cool Outlet Node");
    let sensor = "dx_cooling_coil_system_sensor_node_name";
    assert_eq!(field(&model, DX_COOLING, "Cool", sensor), "Cool Outlet Node");
    assert_eq!(field(&model, "Coil:Heating:Fuel", "Heat", "temperature_setpoint_node_name"), "supply");
}

#[test]
fn only_the_scheduled_setpoint_remains_on_the_branch() {
    let mut model = office();
    make_controllable(&mut model, "L", DENSITY).unwrap();
    assert!(model.names("SetpointManager:MixedAir").is_empty());
    assert!(model.names("SetpointManager:OutdoorAirReset").is_empty());
    let managers = model.objects("SetpointManager:Scheduled");
    let nodes = |schedule: &str| {
        let on = managers.iter().filter(|(_, f)| text(f, "schedule_name") == Some(schedule));
        on.map(|(_, f)| text(f, "setpoint_node_or_nodelist_name").unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(nodes("L Supply Air Temperature"), ["Cool Outlet Node", "supply"]);
    assert!(model.contains("SetpointManager:Scheduled", "Hot Water"));
}

#[test]
fn a_terminal_follows_its_schedule_and_only_heats() {
    let mut model = office();
    make_controllable(&mut model, "L", DENSITY).unwrap();
    let terminal = model.require(REHEAT, "A Box").unwrap();
    assert_eq!(terminal["minimum_air_flow_fraction_schedule_name"], "A Damper Opening");
    assert_eq!(terminal["zone_minimum_air_flow_input_method"], "Scheduled");
    assert_eq!(terminal["damper_heating_action"], "Normal");
    assert!(!terminal.contains_key("constant_minimum_air_flow_fraction"));
    let value = |name| number(model.require("Schedule:Constant", name).unwrap(), "hourly_value");
    assert_eq!(value("A Damper Opening"), Some(0.0));
    assert_eq!(value("A Cooling Setpoint"), Some(OUT_OF_REACH));
    let coil = field(&model, "Coil:Heating:Electric", "A Coil", "availability_schedule_name");
    assert_eq!(coil, ALWAYS_ON);
}

/// Replaces the terminal of zone A by one without reheat.
fn without_reheat(model: &mut Model) {
    let mut fields = model.remove(REHEAT, "A Box").unwrap();
    fields.retain(|field, _| !field.contains("reheat") && !field.contains("damper"));
    model.insert(NO_REHEAT, "A Box", Value::Object(fields));
    let unit = model.require_mut("ZoneHVAC:AirDistributionUnit", "A Unit").unwrap();
    unit.insert("air_terminal_object_type".into(), json!(NO_REHEAT));
}

#[test]
fn a_terminal_without_reheat_has_a_damper_and_the_heater_of_its_zone() {
    let mut model = office();
    without_reheat(&mut model);
    let heated = model.clone();
    let air_loop = make_controllable(&mut model, "L", DENSITY).unwrap();
    assert_eq!(field(&model, NO_REHEAT, "A Box", "zone_minimum_air_flow_input_method"), "Scheduled");
    assert!(air_loop.terminals[0].reheat.is_none() && air_loop.terminals[1].reheat.is_some());
    assert_eq!(air_loop.of_terminals().collect::<Vec<_>>(), [(2, None), (3, Some(4))]);
    assert_eq!([2, 3, 4].map(|actuator| air_loop.zone_of(actuator)), [Some(0), Some(1), Some(1)]);
    assert_eq!([0, 1].map(|zone| air_loop.node_type(zone)), [NodeType::DamperZone, NodeType::VavZone]);

    let mut model = heated;
    let heater = json!({"heating_design_capacity": 1000.0});
    model.insert("ZoneHVAC:Baseboard:Convective:Electric", "A Heater", heater);
    let list = model.require_mut("ZoneHVAC:EquipmentList", "A List").unwrap();
    list["equipment"].as_array_mut().unwrap().push(json!({"zone_equipment_name": "A Heater",
        "zone_equipment_object_type": "ZoneHVAC:Baseboard:Convective:Electric"}));
    let air_loop = make_controllable(&mut model, "L", DENSITY).unwrap();
    let setpoint = air_loop.terminals[0].reheat.as_ref().unwrap();
    assert_eq!(setpoint.key, "A Heating Setpoint");
    assert_eq!(setpoint.heat.as_ref().unwrap().key, "A Heater");
}

#[test]
fn actuators_come_in_the_order_of_the_zones_with_mass_flows() {
    let mut model = office();
    let air_loop = make_controllable(&mut model, "L", DENSITY).unwrap();
    let zones: Vec<_> = air_loop.terminals.iter().map(|t| t.zone.as_str()).collect();
    assert_eq!(zones, ["A", "B"]);
    assert_eq!(air_loop.fan_flow, 2.0 * DENSITY);
    assert_eq!(air_loop.terminals[0].damper.effect_scale, 1.5 * DENSITY);
    assert_eq!(air_loop.terminals[0].damper.effect.key, "A in");
    assert_eq!(air_loop.outdoor_air.key, "OA Controller");
    assert_eq!(air_loop.outdoor_air.effect.key, "outside");
}

#[test]
fn the_economizer_is_disabled() {
    let mut model = office();
    make_controllable(&mut model, "L", DENSITY).unwrap();
    let economizer = field(&model, "Controller:OutdoorAir", "OA Controller", "economizer_control_type");
    assert_eq!(economizer, "NoEconomizer");
}

#[test]
fn a_heating_coil_is_enlarged_to_its_rise_and_never_reduced() {
    for (shipped, expected) in [(100.0, HEATING_COIL_RISE * AIR_SPECIFIC_HEAT * 2.4), (1e9, 1e9)] {
        let mut model = office();
        model.require_mut("Coil:Heating:Fuel", "Heat").unwrap()["nominal_capacity"] = shipped.into();
        enlarge_heating_coil(&mut model, "L", DENSITY).unwrap();
        let heat = model.require("Coil:Heating:Fuel", "Heat").unwrap();
        assert!((number(heat, "nominal_capacity").unwrap() - expected).abs() < 1e-6);
        let air_loop = make_controllable(&mut model, "L", DENSITY).unwrap();
        assert_eq!(air_loop.supply_temperature.high, HIGHEST_SUPPLY_TEMPERATURE);
    }
}

#[test]
fn a_heating_coil_that_keeps_its_size_bounds_the_supply_temperature() {
    let mut model = office();
    let capacity = 4.0 * AIR_SPECIFIC_HEAT * 2.4;
    model.require_mut("Coil:Heating:Fuel", "Heat").unwrap()["nominal_capacity"] = capacity.into();
    let air_loop = make_controllable(&mut model, "L", DENSITY).unwrap();
    assert!((air_loop.supply_temperature.high - (NEUTRAL_SUPPLY_TEMPERATURE + 4.0)).abs() < 1e-9);
    let heat = model.require("Coil:Heating:Fuel", "Heat").unwrap();
    assert_eq!(number(heat, "nominal_capacity"), Some(capacity));
}

#[test]
fn an_unsupported_component_is_named() {
    let refused = |class: &str, name: &str, field: &str, value: &str| {
        let mut model = office();
        model.require_mut(class, name).unwrap().insert(field.into(), value.into());
        make_controllable(&mut model, "L", DENSITY).unwrap_err().to_string()
    };
    let error = refused(DX_COOLING, "Cool", "cooling_coil_object_type", "Coil:Cooling:DX:VariableSpeed");
    assert!(error.contains("`Cool`"), "{error}");
    let error = refused(REHEAT, "B Box", "reheat_coil_object_type", "Coil:Heating:Steam");
    assert!(error.contains("`B Box`"), "{error}");
    let error = refused("Fan:VariableVolume", "Fan", "maximum_flow_rate", "Autosize");
    assert!(error.contains("`Fan`") && error.contains("size the model first"), "{error}");
}

/// The office with a chilled-water coil in the place of its DX coil.
fn chilled_water_office() -> Model {
    let mut model = office();
    model.remove(DX_COOLING, "Cool");
    model.remove("Coil:Cooling:DX:TwoSpeed", "DX");
    let coil = json!({"air_inlet_node_name": "mixed", "air_outlet_node_name": "cold",
        "water_inlet_node_name": "Valve", "water_outlet_node_name": "water out"});
    model.insert("Coil:Cooling:Water", "Cool", coil);
    let control = json!({"actuator_node_name": "VALVE", "sensor_node_name": "cold",
        "control_variable": "Temperature"});
    model.insert("Controller:WaterCoil", "Control", control);
    let branch = model.require_mut("Branch", "Main").unwrap();
    branch["components"][1]["component_object_type"] = "Coil:Cooling:Water".into();
    model
}

#[test]
fn the_valve_of_a_water_coil_follows_the_air_behind_the_moved_coil() {
    let mut model = chilled_water_office();
    make_controllable(&mut model, "L", DENSITY).unwrap();
    assert_eq!(field(&model, "Coil:Cooling:Water", "Cool", "air_outlet_node_name"), "Cool Outlet Node");
    assert_eq!(field(&model, "Coil:Cooling:Water", "Cool", "water_inlet_node_name"), "Valve");
    assert_eq!(field(&model, "Controller:WaterCoil", "Control", "sensor_node_name"), "Cool Outlet Node");
}

#[test]
fn a_water_coil_without_a_temperature_controller_is_rejected() {
    let mut model = chilled_water_office();
    model.require_mut("Controller:WaterCoil", "Control").unwrap()["control_variable"] =
        "HumidityRatio".into();
    let error = make_controllable(&mut model, "L", DENSITY).unwrap_err().to_string();
    assert!(error.contains("`Control`") && error.contains("HumidityRatio"), "{error}");
    let mut model = chilled_water_office();
    model.remove("Controller:WaterCoil", "Control");
    let error = make_controllable(&mut model, "L", DENSITY).unwrap_err().to_string();
    assert!(error.contains("`Cool`") && error.contains("Controller:WaterCoil"), "{error}");
}

#[test]
fn the_bound_of_a_hot_water_coil_follows_its_size() {
    let mut model = office();
    let mut coil = model.remove("Coil:Heating:Fuel", "Heat").unwrap();
    coil.extend([
        ("rated_capacity".to_owned(), json!(10.0 * AIR_SPECIFIC_HEAT * 2.4)),
        ("water_inlet_node_name".to_owned(), json!("valve")),
    ]);
    model.insert(WATER_HEATING, "Heat", Value::Object(coil));
    model.insert("Controller:WaterCoil", "Control", json!({"actuator_node_name": "valve"}));
    model.require_mut("Branch", "Main").unwrap()["components"][2]["component_object_type"] =
        WATER_HEATING.into();
    let air_loop = make_controllable(&mut model, "L", DENSITY).unwrap();
    assert!((air_loop.supply_temperature.high - (NEUTRAL_SUPPLY_TEMPERATURE + 10.0)).abs() < 1e-9);
    assert_eq!(
        model.require(WATER_HEATING, "Heat").unwrap()["rated_capacity"],
        10.0 * AIR_SPECIFIC_HEAT * 2.4
    );
}

#[test]
fn outdoor_air_follows_a_schedule_where_there_are_exhaust_fans() {
    let mut model = office();
    assert_eq!(make_controllable(&mut model, "L", DENSITY).unwrap().exhaust_flow, 0.0);
    let mut model = office();
    let list = model.require_mut("ZoneHVAC:EquipmentList", "A List").unwrap();
    let fan = json!({"zone_equipment_object_type": "Fan:ZoneExhaust", "zone_equipment_name": "Hood"});
    list["equipment"].as_array_mut().unwrap().push(fan);
    model.insert("Fan:ZoneExhaust", "Hood", json!({"maximum_flow_rate": 0.5}));
    let air_loop = make_controllable(&mut model, "L", DENSITY).unwrap();
    assert_eq!(air_loop.exhaust_flow, 0.5 * DENSITY);
    assert_eq!(air_loop.outdoor_air.component, "Schedule:Constant");
    let controller = model.require("Controller:OutdoorAir", "OA Controller").unwrap();
    assert_eq!(controller["minimum_outdoor_air_schedule_name"], air_loop.outdoor_air.key.as_str());
    assert_eq!(controller["minimum_outdoor_air_flow_rate"], 2.0, "the share is of the fan's design flow");
}
