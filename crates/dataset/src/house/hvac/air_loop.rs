//! The ducts: one air loop without outdoor air, blow-through, from the return to one terminal.
//!
//! Nodes, in the order of the air: return → fan → cooling coil → heating coil → backup → supply → terminal → zone; a
//! furnace replaces heating coil and backup.

use b2b_building::Model;
use serde_json::json;

use super::capacities::Capacities;
use super::schedules;
use crate::house::parameters::{Heating, House};
use crate::house::zones::LIVING;

const LOOP: &str = "Air Loop";
pub(crate) const UNIT: &str = "Air Handler";
pub(crate) const COOLING_COIL: &str = "Cooling Coil";
pub(crate) const FAN: &str = "Supply Fan";
const TERMINAL: &str = "Living Terminal";
const DISTRIBUTION: &str = "Living Air Distribution";

const UNIT_INLET: &str = "Return Air";
pub(crate) const FAN_OUTLET: &str = "Fan Outlet";
pub(crate) const COOLING_OUTLET: &str = "Cooling Coil Outlet";
pub(crate) const HEATING_OUTLET: &str = "Heating Coil Outlet";
pub(crate) const UNIT_OUTLET: &str = "Supply Air";
const DUCT_INLET: &str = "Supply Duct";
const TERMINAL_INLET: &str = "Living Terminal Inlet";
const ZONE_INLET: &str = "Living Supply Air";
const ZONE_RETURN: &str = "Living Return Air";
const RETURN_OUTLET: &str = "Return Duct";

/// Total pressure of a residential air handler with filter, coils and ducts, Pa, and its efficiency: 770 W per m³/s,
/// the fan power that AHRI 210/240 assumes (365 W per 1000 cfm).
pub(crate) const FAN_PRESSURE: f64 = 300.0;
pub(crate) const FAN_EFFICIENCY: f64 = 0.39;
/// Motor efficiency (engineering judgment).
pub(crate) const MOTOR_EFFICIENCY: f64 = 0.65;
/// Fan power over design power by flow fraction (ASHRAE 90.1 Appendix G, variable-speed drive).
const FAN_POWER: [f64; 5] = [0.0408, 0.088, -0.0729, 0.9437, 0.0];

/// Thermostat, °C. A zone above its cooling setpoint would open the damper beyond the command, so this setpoint is out
/// of reach. The heating setpoint has no effect (measured from 5 to 35 °C).
const HEATING_SETPOINT: f64 = 5.0;
const COOLING_SETPOINT: f64 = 90.0;
/// Supply temperature before the first command, °C.
const SUPPLY_TEMPERATURE: f64 = 21.0;

pub(crate) fn add(model: &mut Model, house: &House, capacities: &Capacities) {
    commands(model);
    supply_side(model, capacities);
    unit(model, capacities);
    fan(model, capacities);
    setpoint_managers(model, house);
    demand_side(model);
    terminal(model, capacities);
    zone(model);
    thermostat(model);
}

fn commands(model: &mut Model) {
    let flow = schedules::supply_air_flow_fraction(LIVING);
    schedules::constant(model, &flow, 0.0);
    let temperature = schedules::supply_air_temperature(LIVING);
    schedules::constant(model, &temperature, SUPPLY_TEMPERATURE);
}

fn supply_side(model: &mut Model, capacities: &Capacities) {
    let air_loop = json!({
        "design_supply_air_flow_rate": capacities.flow,
        "branch_list_name": "Air Loop Branches",
        "supply_side_inlet_node_name": UNIT_INLET,
        "supply_side_outlet_node_names": UNIT_OUTLET,
        "demand_side_inlet_node_names": DUCT_INLET,
        "demand_side_outlet_node_name": RETURN_OUTLET,
    });
    model.insert("AirLoopHVAC", LOOP, air_loop);
    let branches = json!({"branches": [{"branch_name": "Air Loop Branch"}]});
    model.insert("BranchList", "Air Loop Branches", branches);
    let branch = json!({"components": [{
        "component_object_type": "AirLoopHVAC:UnitarySystem",
        "component_name": UNIT,
        "component_inlet_node_name": UNIT_INLET,
        "component_outlet_node_name": UNIT_OUTLET,
    }]});
    model.insert("Branch", "Air Loop Branch", branch);
}

fn unit(model: &mut Model, capacities: &Capacities) {
    let mut unit = json!({
        "control_type": "SetPoint",
        "controlling_zone_or_thermostat_location": LIVING,
        "availability_schedule_name": schedules::ALWAYS,
        "supply_air_fan_operating_mode_schedule_name": schedules::ALWAYS,
        "air_inlet_node_name": UNIT_INLET,
        "air_outlet_node_name": UNIT_OUTLET,
        "supply_fan_object_type": "Fan:VariableVolume",
        "supply_fan_name": FAN,
        "fan_placement": "BlowThrough",
        "cooling_coil_object_type": "Coil:Cooling:DX:TwoSpeed",
        "cooling_coil_name": COOLING_COIL,
        "maximum_supply_air_temperature": 80.0,
        // Backup heat is allowed up to 21 °C outdoors: the agent chooses the supply temperature and bears its cost.
        "maximum_outdoor_dry_bulb_temperature_for_supplemental_heater_operation": 21.0,
    });
    for mode in ["cooling_supply", "heating_supply", "no_load_supply"] {
        unit[format!("{mode}_air_flow_rate_method")] = json!("SupplyAirFlowRate");
        unit[format!("{mode}_air_flow_rate")] = json!(capacities.flow);
    }
    model.insert("AirLoopHVAC:UnitarySystem", UNIT, unit);
}

fn fan(model: &mut Model, capacities: &Capacities) {
    let mut fan = json!({
        "availability_schedule_name": schedules::ALWAYS,
        "air_inlet_node_name": UNIT_INLET,
        "air_outlet_node_name": FAN_OUTLET,
        "maximum_flow_rate": capacities.flow,
        "pressure_rise": FAN_PRESSURE,
        "fan_total_efficiency": FAN_EFFICIENCY,
        "motor_efficiency": MOTOR_EFFICIENCY,
        "motor_in_airstream_fraction": 1.0,
        "fan_power_minimum_flow_rate_input_method": "Fraction",
        "fan_power_minimum_flow_fraction": 0.0,
    });
    for (index, coefficient) in FAN_POWER.iter().enumerate() {
        fan[format!("fan_power_coefficient_{}", index + 1)] = json!(coefficient);
    }
    model.insert("Fan:VariableVolume", FAN, fan);
}

fn setpoint_managers(model: &mut Model, house: &House) {
    let after_heat_pump = matches!(house.heating, Heating::HeatPump { .. }).then_some(HEATING_OUTLET);
    for node in [COOLING_OUTLET, UNIT_OUTLET, DUCT_INLET].into_iter().chain(after_heat_pump) {
        let manager = json!({
            "control_variable": "Temperature",
            "schedule_name": schedules::supply_air_temperature(LIVING),
            "setpoint_node_or_nodelist_name": node,
        });
        model.insert("SetpointManager:Scheduled", &format!("{node} Setpoint"), manager);
    }
}

fn demand_side(model: &mut Model) {
    let supply = json!({
        "supply_air_path_inlet_node_name": DUCT_INLET,
        "components": [{
            "component_object_type": "AirLoopHVAC:ZoneSplitter",
            "component_name": "Supply Splitter",
        }],
    });
    model.insert("AirLoopHVAC:SupplyPath", "Supply Path", supply);
    let splitter = json!({
        "inlet_node_name": DUCT_INLET,
        "nodes": [{"outlet_node_name": TERMINAL_INLET}],
    });
    model.insert("AirLoopHVAC:ZoneSplitter", "Supply Splitter", splitter);
    let back = json!({
        "return_air_path_outlet_node_name": RETURN_OUTLET,
        "components": [{
            "component_object_type": "AirLoopHVAC:ZoneMixer",
            "component_name": "Return Mixer",
        }],
    });
    model.insert("AirLoopHVAC:ReturnPath", "Return Path", back);
    let mixer = json!({
        "outlet_node_name": RETURN_OUTLET,
        "nodes": [{"inlet_node_name": ZONE_RETURN}],
    });
    model.insert("AirLoopHVAC:ZoneMixer", "Return Mixer", mixer);
}

fn terminal(model: &mut Model, capacities: &Capacities) {
    let terminal = json!({
        "availability_schedule_name": schedules::ALWAYS,
        "air_inlet_node_name": TERMINAL_INLET,
        "air_outlet_node_name": ZONE_INLET,
        "maximum_air_flow_rate": capacities.flow,
        "zone_minimum_air_flow_input_method": "Scheduled",
        "minimum_air_flow_fraction_schedule_name": schedules::supply_air_flow_fraction(LIVING),
    });
    model.insert("AirTerminal:SingleDuct:VAV:NoReheat", TERMINAL, terminal);
    let distribution = json!({
        "air_distribution_unit_outlet_node_name": ZONE_INLET,
        "air_terminal_object_type": "AirTerminal:SingleDuct:VAV:NoReheat",
        "air_terminal_name": TERMINAL,
    });
    model.insert("ZoneHVAC:AirDistributionUnit", DISTRIBUTION, distribution);
}

fn zone(model: &mut Model) {
    let connections = json!({
        "zone_name": LIVING,
        "zone_conditioning_equipment_list_name": "Living Equipment",
        "zone_air_inlet_node_or_nodelist_name": ZONE_INLET,
        "zone_air_node_name": "Living Air",
        "zone_return_air_node_or_nodelist_name": ZONE_RETURN,
    });
    model.insert("ZoneHVAC:EquipmentConnections", "Living Connections", connections);
    let equipment = json!({"equipment": [{
        "zone_equipment_object_type": "ZoneHVAC:AirDistributionUnit",
        "zone_equipment_name": DISTRIBUTION,
        "zone_equipment_cooling_sequence": 1,
        "zone_equipment_heating_or_no_load_sequence": 1,
    }]});
    model.insert("ZoneHVAC:EquipmentList", "Living Equipment", equipment);
}

fn thermostat(model: &mut Model) {
    let (heating, cooling) = (schedules::heating_setpoint(LIVING), schedules::cooling_setpoint(LIVING));
    schedules::constant(model, &heating, HEATING_SETPOINT);
    schedules::constant(model, &cooling, COOLING_SETPOINT);
    // 4: heating and cooling setpoints together.
    schedules::constant(model, "Dual Setpoint", 4.0);
    let thermostat = json!({
        "zone_or_zonelist_name": LIVING,
        "control_type_schedule_name": "Dual Setpoint",
        "control_1_object_type": "ThermostatSetpoint:DualSetpoint",
        "control_1_name": "Living Setpoints",
    });
    model.insert("ZoneControl:Thermostat", "Living Thermostat", thermostat);
    let setpoints = json!({
        "heating_setpoint_temperature_schedule_name": heating,
        "cooling_setpoint_temperature_schedule_name": cooling,
    });
    model.insert("ThermostatSetpoint:DualSetpoint", "Living Setpoints", setpoints);
}
