//! A room with a packaged terminal heat pump.

use serde_json::{Value, json};

use crate::setpoints::room::room;

/// Design flow of the unit, m³/s.
pub const FLOW: f64 = 0.5;
/// Its outdoor air, m³/s.
pub const OUTDOOR_AIR: f64 = 0.05;

/// Returns the model, as epJSON, with four people in the room at every hour.
pub fn model() -> Value {
    let mut model = room();
    let classes = model.as_object_mut().unwrap();
    classes.remove("ZoneHVAC:IdealLoadsAirSystem");
    let parts = [people(), mixer(), unit(), equipment(), coils(), curves()];
    parts.into_iter().for_each(|part| {
        let Value::Object(part) = part else { panic!("a group of classes") };
        classes.extend(part);
    });
    for (name, value) in [("On", 1.0), ("Seated", 120.0)] {
        classes["Schedule:Constant"][name] = json!({"hourly_value": value});
    }
    model
}

fn people() -> Value {
    json!({"People": {"People": {
        "zone_or_zonelist_or_space_or_spacelist_name": "Room", "number_of_people": 4,
        "number_of_people_schedule_name": "On", "activity_level_schedule_name": "Seated"}}})
}

fn equipment() -> Value {
    json!({
        "ZoneHVAC:EquipmentConnections": {"C": {
            "zone_name": "Room",
            "zone_conditioning_equipment_list_name": "List",
            "zone_air_inlet_node_or_nodelist_name": "Inlet",
            "zone_air_exhaust_node_or_nodelist_name": "To Unit",
            "zone_air_node_name": "Air"}},
        "ZoneHVAC:EquipmentList": {"List": {"equipment": [{
            "zone_equipment_object_type": "ZoneHVAC:PackagedTerminalHeatPump",
            "zone_equipment_name": "Unit",
            "zone_equipment_cooling_sequence": 1,
            "zone_equipment_heating_or_no_load_sequence": 1}]}},
        "OutdoorAir:Node": {"Outside": {}},
    })
}

fn mixer() -> Value {
    json!({"OutdoorAir:Mixer": {"Mixer": {
        "mixed_air_node_name": "Mixed",
        "outdoor_air_stream_node_name": "Outside",
        "relief_air_stream_node_name": "Relief",
        "return_air_stream_node_name": "To Unit"}}})
}

fn unit() -> Value {
    let mut unit = json!({
        "availability_schedule_name": "On",
        "air_inlet_node_name": "To Unit",
        "air_outlet_node_name": "Inlet",
        "outdoor_air_mixer_object_type": "OutdoorAir:Mixer",
        "outdoor_air_mixer_name": "Mixer",
        "supply_air_fan_object_type": "Fan:OnOff",
        "supply_air_fan_name": "Fan",
        "heating_coil_object_type": "Coil:Heating:DX:SingleSpeed",
        "heating_coil_name": "Compressor Heating",
        "cooling_coil_object_type": "Coil:Cooling:DX:SingleSpeed",
        "cooling_coil_name": "Compressor Cooling",
        "supplemental_heating_coil_object_type": "Coil:Heating:Electric",
        "supplemental_heating_coil_name": "Backup",
        "maximum_supply_air_temperature_from_supplemental_heater": 50.0,
        "fan_placement": "DrawThrough",
        "supply_air_fan_operating_mode_schedule_name": "On",
    });
    for regime in ["cooling", "heating", "no_load"] {
        unit[format!("{regime}_supply_air_flow_rate")] = json!(FLOW);
        unit[format!("{regime}_outdoor_air_flow_rate")] = json!(OUTDOOR_AIR);
    }
    json!({
        "ZoneHVAC:PackagedTerminalHeatPump": {"Unit": unit},
        "Fan:OnOff": {"Fan": {
            "availability_schedule_name": "On",
            "maximum_flow_rate": FLOW,
            "pressure_rise": 100.0,
            "air_inlet_node_name": "3",
            "air_outlet_node_name": "4"}},
    })
}

fn coils() -> Value {
    let mut cooling = json!({
        "availability_schedule_name": "On",
        "gross_rated_total_cooling_capacity": 10e3,
        "gross_rated_sensible_heat_ratio": 0.75,
        "gross_rated_cooling_cop": 3.5,
        "rated_air_flow_rate": FLOW,
        "air_inlet_node_name": "Mixed",
        "air_outlet_node_name": "1",
        "part_load_fraction_correlation_curve_name": "Constant",
    });
    for curve in ["total_cooling_capacity", "energy_input_ratio"] {
        cooling[format!("{curve}_function_of_temperature_curve_name")] = json!("Flat");
        cooling[format!("{curve}_function_of_flow_fraction_curve_name")] = json!("Constant");
    }
    let mut heating = json!({
        "availability_schedule_name": "On",
        "gross_rated_heating_capacity": 10e3,
        "gross_rated_heating_cop": 3.0,
        "rated_air_flow_rate": FLOW,
        "air_inlet_node_name": "1",
        "air_outlet_node_name": "2",
        "part_load_fraction_correlation_curve_name": "Constant",
        "defrost_strategy": "Resistive",
        "resistive_defrost_heater_capacity": 0.0,
    });
    for curve in ["heating_capacity", "energy_input_ratio"] {
        heating[format!("{curve}_function_of_temperature_curve_name")] = json!("Flat");
        heating[format!("{curve}_function_of_flow_fraction_curve_name")] = json!("Constant");
    }
    json!({
        "Coil:Cooling:DX:SingleSpeed": {"Compressor Cooling": cooling},
        "Coil:Heating:DX:SingleSpeed": {"Compressor Heating": heating},
        "Coil:Heating:Electric": {"Backup": {
            "availability_schedule_name": "On",
            "efficiency": 1.0,
            "nominal_capacity": 15e3,
            "air_inlet_node_name": "4",
            "air_outlet_node_name": "Inlet"}},
    })
}

/// Curves that are 1 everywhere.
fn curves() -> Value {
    let with_zeros = |names: &[&str]| {
        let mut curve = json!({"coefficient1_constant": 1.0});
        names.iter().for_each(|name| curve[*name] = json!(0.0));
        for (variable, name) in ["x", "y"].into_iter().zip([0, 3]) {
            if names.len() > name {
                curve[format!("minimum_value_of_{variable}")] = json!(-60.0);
                curve[format!("maximum_value_of_{variable}")] = json!(60.0);
            }
        }
        curve
    };
    let two =
        ["coefficient2_x", "coefficient3_x_2", "coefficient4_y", "coefficient5_y_2", "coefficient6_x_y"];
    json!({
        "Curve:Quadratic": {"Constant": with_zeros(&two[..2])},
        "Curve:Biquadratic": {"Flat": with_zeros(&two)},
    })
}
