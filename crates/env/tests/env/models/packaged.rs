//! A room with a packaged unit.

use serde_json::{Value, json};

use super::room::room;

/// Design flow of the unit, m³/s.
pub const FLOW: f64 = 0.5;
/// Outdoor air of a unit that takes some, m³/s.
pub const OUTDOOR_AIR: f64 = 0.05;
/// Node where a unit takes the air of the room.
const FROM_ROOM: &str = "To Unit";
/// Node where a unit delivers air.
const TO_ROOM: &str = "Inlet";

/// A packaged terminal heat pump with electric backup.
pub fn heat_pump() -> Value {
    let mut heat_pump = with_outdoor_air("supply_air_fan");
    let more = json!({
        "heating_coil_object_type": "Coil:Heating:DX:SingleSpeed",
        "heating_coil_name": "Compressor Heating",
        "supplemental_heating_coil_object_type": "Coil:Heating:Electric",
        "supplemental_heating_coil_name": "Electric",
        "maximum_supply_air_temperature_from_supplemental_heater": 50.0,
    });
    extend(&mut heat_pump, more);
    let mut model = model("ZoneHVAC:PackagedTerminalHeatPump", heat_pump);
    extend(&mut model, cooling("Mixed"));
    extend(&mut model, json!({"Coil:Heating:DX:SingleSpeed": {"Compressor Heating": compressor_heating()}}));
    extend(&mut model, electric("4", TO_ROOM));
    model
}

/// A packaged terminal air conditioner that heats by electricity.
pub fn air_conditioner() -> Value {
    let mut unit = with_outdoor_air("supply_air_fan");
    extend(&mut unit, electric_heating());
    let mut model = model("ZoneHVAC:PackagedTerminalAirConditioner", unit);
    extend(&mut model, cooling("Mixed"));
    extend(&mut model, electric("1", "2"));
    model
}

/// A unitary system without ducts and outdoor air.
pub fn unitary_system() -> Value {
    let mut unit = without_outdoor_air("supply_fan");
    extend(&mut unit, electric_heating());
    let more = json!({
        "control_type": "Load",
        "controlling_zone_or_thermostat_location": "Room",
        "dehumidification_control_type": "None",
    });
    extend(&mut unit, more);
    for regime in ["cooling", "heating", "no_load"] {
        unit[format!("{regime}_supply_air_flow_rate_method")] = json!("SupplyAirFlowRate");
    }
    let mut model = model("AirLoopHVAC:UnitarySystem", unit);
    model.as_object_mut().unwrap().remove("OutdoorAir:Mixer");
    extend(&mut model, cooling(FROM_ROOM));
    extend(&mut model, electric("1", "2"));
    model
}

/// Returns the model of a room with a unit of a class and its fan, with four people at every hour.
pub(super) fn model(class: &str, unit: Value) -> Value {
    let mut model = room();
    let classes = model.as_object_mut().unwrap();
    classes.remove("ZoneHVAC:IdealLoadsAirSystem");
    classes.insert(class.to_owned(), json!({"Unit": unit}));
    for part in [people(), mixer(), fan(), equipment(class), curves()] {
        extend(&mut model, part);
    }
    for (name, value) in [("On", 1.0), ("Seated", 120.0)] {
        model["Schedule:Constant"][name] = json!({"hourly_value": value});
    }
    model
}

/// Adds fields or classes.
pub(super) fn extend(object: &mut Value, more: Value) {
    let Value::Object(more) = more else { panic!("an object") };
    object.as_object_mut().unwrap().extend(more);
}

fn people() -> Value {
    json!({"People": {"People": {
        "zone_or_zonelist_or_space_or_spacelist_name": "Room", "number_of_people": 4,
        "number_of_people_schedule_name": "On", "activity_level_schedule_name": "Seated"}}})
}

fn equipment(class: &str) -> Value {
    json!({
        "ZoneHVAC:EquipmentConnections": {"C": {
            "zone_name": "Room",
            "zone_conditioning_equipment_list_name": "List",
            "zone_air_inlet_node_or_nodelist_name": TO_ROOM,
            "zone_air_exhaust_node_or_nodelist_name": FROM_ROOM,
            "zone_air_node_name": "Air"}},
        "ZoneHVAC:EquipmentList": {"List": {"equipment": [{
            "zone_equipment_object_type": class,
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
        "return_air_stream_node_name": FROM_ROOM}}})
}

/// The fields of a unit that takes outdoor air, but for its heating coils. `fan` begins the names of the fields of its
/// fan.
fn with_outdoor_air(fan: &str) -> Value {
    let mut unit = without_outdoor_air(fan);
    let mixer =
        json!({"outdoor_air_mixer_object_type": "OutdoorAir:Mixer", "outdoor_air_mixer_name": "Mixer"});
    extend(&mut unit, mixer);
    for regime in ["cooling", "heating", "no_load"] {
        unit[format!("{regime}_outdoor_air_flow_rate")] = json!(OUTDOOR_AIR);
    }
    unit
}

fn without_outdoor_air(fan: &str) -> Value {
    let mut unit = json!({
        "availability_schedule_name": "On",
        "air_inlet_node_name": FROM_ROOM,
        "air_outlet_node_name": TO_ROOM,
        (format!("{fan}_object_type")): "Fan:OnOff",
        (format!("{fan}_name")): "Fan",
        "cooling_coil_object_type": "Coil:Cooling:DX:SingleSpeed",
        "cooling_coil_name": "Compressor Cooling",
        "fan_placement": "DrawThrough",
        "supply_air_fan_operating_mode_schedule_name": "On",
    });
    for regime in ["cooling", "heating", "no_load"] {
        unit[format!("{regime}_supply_air_flow_rate")] = json!(FLOW);
    }
    unit
}

fn electric_heating() -> Value {
    json!({"heating_coil_object_type": "Coil:Heating:Electric", "heating_coil_name": "Electric"})
}

fn fan() -> Value {
    json!({"Fan:OnOff": {"Fan": {
        "availability_schedule_name": "On",
        "maximum_flow_rate": FLOW,
        "pressure_rise": 100.0,
        "air_inlet_node_name": "3",
        "air_outlet_node_name": "4"}}})
}

/// An electric heating coil between two nodes.
pub(super) fn electric(inlet: &str, outlet: &str) -> Value {
    json!({"Coil:Heating:Electric": {"Electric": {
        "availability_schedule_name": "On",
        "efficiency": 1.0,
        "nominal_capacity": 15e3,
        "air_inlet_node_name": inlet,
        "air_outlet_node_name": outlet}}})
}

fn cooling(inlet: &str) -> Value {
    let mut cooling = json!({
        "availability_schedule_name": "On",
        "gross_rated_total_cooling_capacity": 10e3,
        "gross_rated_sensible_heat_ratio": 0.75,
        "gross_rated_cooling_cop": 3.5,
        "rated_air_flow_rate": FLOW,
        "air_inlet_node_name": inlet,
        "air_outlet_node_name": "1",
        "part_load_fraction_correlation_curve_name": "Constant",
    });
    for curve in ["total_cooling_capacity", "energy_input_ratio"] {
        cooling[format!("{curve}_function_of_temperature_curve_name")] = json!("Flat");
        cooling[format!("{curve}_function_of_flow_fraction_curve_name")] = json!("Constant");
    }
    json!({"Coil:Cooling:DX:SingleSpeed": {"Compressor Cooling": cooling}})
}

fn compressor_heating() -> Value {
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
    heating
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
