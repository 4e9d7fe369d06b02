//! A room with a four-pipe fan coil on district cooling.

use serde_json::{Value, json};

use super::packaged::{FLOW, OUTDOOR_AIR, electric, extend, model};

/// Design flow of chilled water, m³/s: 10 kW at 6 K.
const WATER: f64 = 4e-4;

/// Returns the model.
pub fn fan_coil() -> Value {
    let unit = json!({
        "availability_schedule_name": "On",
        "capacity_control_method": "CyclingFan",
        "maximum_supply_air_flow_rate": FLOW,
        "maximum_outdoor_air_flow_rate": OUTDOOR_AIR,
        "air_inlet_node_name": "To Unit",
        "air_outlet_node_name": "Inlet",
        "outdoor_air_mixer_object_type": "OutdoorAir:Mixer",
        "outdoor_air_mixer_name": "Mixer",
        "supply_air_fan_object_type": "Fan:OnOff",
        "supply_air_fan_name": "Fan",
        "cooling_coil_object_type": "Coil:Cooling:Water",
        "cooling_coil_name": "Chilled",
        "maximum_cold_water_flow_rate": WATER,
        "heating_coil_object_type": "Coil:Heating:Electric",
        "heating_coil_name": "Electric",
    });
    let mut model = model("ZoneHVAC:FourPipeFanCoil", unit);
    for part in [electric("1", "Inlet"), coil(), plant(), branches(), lists()] {
        extend(&mut model, part);
    }
    model["Schedule:Constant"]["Chilled Water"] = json!({"hourly_value": 7.0});
    model
}

fn coil() -> Value {
    json!({"Coil:Cooling:Water": {"Chilled": {
        "availability_schedule_name": "On",
        "design_water_flow_rate": WATER,
        "design_air_flow_rate": FLOW,
        "design_inlet_water_temperature": 7.0,
        "design_inlet_air_temperature": 26.0,
        "design_outlet_air_temperature": 13.0,
        "design_inlet_air_humidity_ratio": 0.010,
        "design_outlet_air_humidity_ratio": 0.009,
        "water_inlet_node_name": "Coil Water Inlet",
        "water_outlet_node_name": "Coil Water Outlet",
        "air_inlet_node_name": "4",
        "air_outlet_node_name": "1",
        "type_of_analysis": "SimpleAnalysis",
        "heat_exchanger_configuration": "CrossFlow"}}})
}

fn plant() -> Value {
    json!({
        "PlantLoop": {"Chilled Water": {
            "fluid_type": "Water",
            "plant_equipment_operation_scheme_name": "Operation",
            "loop_temperature_setpoint_node_name": "Supply Outlet",
            "maximum_loop_temperature": 98.0,
            "minimum_loop_temperature": 1.0,
            "maximum_loop_flow_rate": WATER,
            "minimum_loop_flow_rate": 0.0,
            "plant_loop_volume": "Autocalculate",
            "plant_side_inlet_node_name": "Supply Inlet",
            "plant_side_outlet_node_name": "Supply Outlet",
            "plant_side_branch_list_name": "Supply Branches",
            "plant_side_connector_list_name": "Supply Connectors",
            "demand_side_inlet_node_name": "Demand Inlet",
            "demand_side_outlet_node_name": "Demand Outlet",
            "demand_side_branch_list_name": "Demand Branches",
            "demand_side_connector_list_name": "Demand Connectors",
            "load_distribution_scheme": "SequentialLoad"}},
        "SetpointManager:Scheduled": {"Chilled Water": {
            "control_variable": "Temperature",
            "schedule_name": "Chilled Water",
            "setpoint_node_or_nodelist_name": "Supply Outlet"}},
        "PlantEquipmentOperationSchemes": {"Operation": {
            "control_scheme_1_object_type": "PlantEquipmentOperation:CoolingLoad",
            "control_scheme_1_name": "Cooling",
            "control_scheme_1_schedule_name": "On"}},
        "PlantEquipmentOperation:CoolingLoad": {"Cooling": {
            "load_range_1_lower_limit": 0.0,
            "load_range_1_upper_limit": 1e9,
            "range_1_equipment_list_name": "Equipment"}},
        "PlantEquipmentList": {"Equipment": {"equipment": [{
            "equipment_object_type": "DistrictCooling", "equipment_name": "District"}]}},
        "DistrictCooling": {"District": {
            "chilled_water_inlet_node_name": "District Inlet",
            "chilled_water_outlet_node_name": "District Outlet",
            "nominal_capacity": 12e3}},
        "Pump:VariableSpeed": {"Pump": {
            "inlet_node_name": "Supply Inlet",
            "outlet_node_name": "Pump Outlet",
            "design_maximum_flow_rate": WATER,
            "design_pump_head": 5e4,
            "design_power_consumption": 40.0,
            "motor_efficiency": 0.9,
            "pump_control_type": "Intermittent"}},
    })
}

/// A component on its own branch.
fn branch(class: &str, name: &str, [inlet, outlet]: [&str; 2]) -> Value {
    json!({"components": [{
        "component_object_type": class, "component_name": name,
        "component_inlet_node_name": inlet, "component_outlet_node_name": outlet}]})
}

fn pipe([inlet, outlet]: [&str; 2]) -> Value {
    json!({"inlet_node_name": inlet, "outlet_node_name": outlet})
}

const PIPE: &str = "Pipe:Adiabatic";
const OUT: [&str; 2] = ["Supply Pipe Inlet", "Supply Outlet"];
const BYPASS: [&str; 2] = ["Bypass Inlet", "Bypass Outlet"];
const IN: [&str; 2] = ["Demand Inlet", "Demand Pipe Outlet"];
const AROUND: [&str; 2] = ["Around Inlet", "Around Outlet"];
const BACK: [&str; 2] = ["Demand Return", "Demand Outlet"];

fn branches() -> Value {
    json!({
        "Branch": {
            "Pump": branch("Pump:VariableSpeed", "Pump", ["Supply Inlet", "Pump Outlet"]),
            "District": branch("DistrictCooling", "District", ["District Inlet", "District Outlet"]),
            "Bypass": branch(PIPE, "Bypass", BYPASS),
            "Out": branch(PIPE, "Out", OUT),
            "In": branch(PIPE, "In", IN),
            "Coil": branch("Coil:Cooling:Water", "Chilled", ["Coil Water Inlet", "Coil Water Outlet"]),
            "Around": branch(PIPE, "Around", AROUND),
            "Back": branch(PIPE, "Back", BACK)},
        (PIPE): {
            "Bypass": pipe(BYPASS), "Out": pipe(OUT), "In": pipe(IN), "Around": pipe(AROUND), "Back": pipe(BACK)},
    })
}

/// The branches of both sides, with a splitter and a mixer each.
fn lists() -> Value {
    let list = |names: [&str; 4]| json!({"branches": names.map(|name| json!({"branch_name": name}))});
    let connectors = |side: &str| {
        json!({
            "connector_1_object_type": "Connector:Splitter", "connector_1_name": format!("{side} Splitter"),
            "connector_2_object_type": "Connector:Mixer", "connector_2_name": format!("{side} Mixer")})
    };
    let splitter = |inlet: &str, outlets: [&str; 2]| {
        json!({"inlet_branch_name": inlet,
            "branches": outlets.map(|name| json!({"outlet_branch_name": name}))})
    };
    let mixer = |inlets: [&str; 2], outlet: &str| json!({"outlet_branch_name": outlet, "branches": inlets.map(|name| json!({"inlet_branch_name": name}))});
    json!({
        "BranchList": {
            "Supply Branches": list(["Pump", "District", "Bypass", "Out"]),
            "Demand Branches": list(["In", "Coil", "Around", "Back"])},
        "ConnectorList": {"Supply Connectors": connectors("Supply"), "Demand Connectors": connectors("Demand")},
        "Connector:Splitter": {
            "Supply Splitter": splitter("Pump", ["District", "Bypass"]),
            "Demand Splitter": splitter("In", ["Coil", "Around"])},
        "Connector:Mixer": {
            "Supply Mixer": mixer(["District", "Bypass"], "Out"),
            "Demand Mixer": mixer(["Coil", "Around"], "Back")},
    })
}
