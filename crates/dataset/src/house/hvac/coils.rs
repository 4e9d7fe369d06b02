//! The coils: cooling, the heat pump's heating, furnace or backup; and their performance curves.
//!
//! The curves are from the heat pumps of the ASHRAE 90.1 small office prototype, relative to rated conditions.

use b2b_building::Model;
use serde_json::{Value, json};

use super::air_loop::{COOLING_COIL, COOLING_OUTLET, FAN_OUTLET, HEATING_OUTLET, UNIT, UNIT_OUTLET};
use super::capacities::Capacities;
use crate::house::hvac::{loads, schedules};
use crate::house::parameters::{Heater, Heating, House};

const HEATING: &str = "Heating Coil";
const BACKUP: &str = "Backup Heater";
const FURNACE: &str = "Furnace";
const HEAT_PUMP: &str = "Coil:Heating:DX:SingleSpeed";

/// Low speed over high speed: capacity and air flow, within the flow per capacity that EnergyPlus accepts.
const LOW_SPEED: [f64; 2] = [0.5, 0.55];
/// Input of reverse-cycle defrost over rated capacity, as in NREL's ResStock. EnergyPlus notes once that this is not
/// 1.0 at rated conditions; 1.0 multiplies defrost energy by 6.6 (measured).
const DEFROST_INPUT: f64 = 0.1528;
/// Outdoor temperature below which the compressor does not cool, °C: never reached, so an overheated room can always be
/// cooled.
const COOLING_LOCKOUT: f64 = -60.0;

pub(crate) fn add(model: &mut Model, house: &House, capacities: &Capacities) {
    curves(model);
    cooling(model, house, capacities);
    match house.heating {
        Heating::HeatPump { cop, cutoff, backup } => {
            heat_pump(model, capacities, cop, cutoff);
            refer(model, "heating_coil", HEAT_PUMP, HEATING);
            let class = heater(model, BACKUP, backup, HEATING_OUTLET, capacities);
            refer(model, "supplemental_heating_coil", class, BACKUP);
        }
        Heating::Furnace(furnace) => {
            let class = heater(model, FURNACE, furnace, COOLING_OUTLET, capacities);
            refer(model, "heating_coil", class, FURNACE);
        }
    }
}

/// Names a coil in the unit.
fn refer(model: &mut Model, role: &str, class: &str, name: &str) {
    if let Some(unit) = model.get_mut("AirLoopHVAC:UnitarySystem", UNIT) {
        unit.insert(format!("{role}_object_type"), json!(class));
        unit.insert(format!("{role}_name"), json!(name));
    }
}

fn cooling(model: &mut Model, house: &House, capacities: &Capacities) {
    let [low_capacity, low_flow] = LOW_SPEED;
    let coil = json!({
        "availability_schedule_name": schedules::ALWAYS,
        "air_inlet_node_name": FAN_OUTLET,
        "air_outlet_node_name": COOLING_OUTLET,
        "high_speed_gross_rated_total_cooling_capacity": capacities.cooling,
        "high_speed_gross_rated_cooling_cop": house.cooling_cop,
        "high_speed_rated_air_flow_rate": capacities.flow,
        "high_speed_rated_sensible_heat_ratio": loads::SENSIBLE,
        "low_speed_gross_rated_total_cooling_capacity": low_capacity * capacities.cooling,
        "low_speed_gross_rated_cooling_cop": house.cooling_cop,
        "low_speed_rated_air_flow_rate": low_flow * capacities.flow,
        "low_speed_gross_rated_sensible_heat_ratio": loads::SENSIBLE,
        "total_cooling_capacity_function_of_temperature_curve_name": "Cooling Capacity by Temperature",
        "total_cooling_capacity_function_of_flow_fraction_curve_name": "Cooling Capacity by Flow",
        "energy_input_ratio_function_of_temperature_curve_name": "Cooling Input by Temperature",
        "energy_input_ratio_function_of_flow_fraction_curve_name": "Cooling Input by Flow",
        "low_speed_total_cooling_capacity_function_of_temperature_curve_name": "Cooling Capacity by Temperature",
        "low_speed_energy_input_ratio_function_of_temperature_curve_name": "Cooling Input by Temperature",
        "part_load_fraction_correlation_curve_name": "Cycling Loss",
        "minimum_outdoor_dry_bulb_temperature_for_compressor_operation": COOLING_LOCKOUT,
    });
    model.insert("Coil:Cooling:DX:TwoSpeed", COOLING_COIL, coil);
}

fn heat_pump(model: &mut Model, capacities: &Capacities, cop: f64, cutoff: f64) {
    let coil = json!({
        "availability_schedule_name": schedules::ALWAYS,
        "air_inlet_node_name": COOLING_OUTLET,
        "air_outlet_node_name": HEATING_OUTLET,
        "gross_rated_heating_capacity": capacities.heating,
        "gross_rated_heating_cop": cop,
        "rated_air_flow_rate": capacities.flow,
        "heating_capacity_function_of_temperature_curve_name": "Heating Capacity by Temperature",
        "heating_capacity_function_of_flow_fraction_curve_name": "Heating Capacity by Flow",
        "energy_input_ratio_function_of_temperature_curve_name": "Heating Input by Temperature",
        "energy_input_ratio_function_of_flow_fraction_curve_name": "Heating Input by Flow",
        "part_load_fraction_correlation_curve_name": "Cycling Loss",
        "minimum_outdoor_dry_bulb_temperature_for_compressor_operation": cutoff,
        "defrost_strategy": "ReverseCycle",
        "defrost_control": "OnDemand",
        "defrost_energy_input_ratio_function_of_temperature_curve_name": "Defrost Input",
        "maximum_outdoor_dry_bulb_temperature_for_defrost_operation": 4.4,
        "resistive_defrost_heater_capacity": 0.0,
        "crankcase_heater_capacity": 0.0,
    });
    model.insert(HEAT_PUMP, HEATING, coil);
}

/// A heater from a node to the unit's outlet. Returns its class.
fn heater(
    model: &mut Model,
    name: &str,
    heater: Heater,
    inlet: &str,
    capacities: &Capacities,
) -> &'static str {
    let mut coil = json!({
        "availability_schedule_name": schedules::ALWAYS,
        "air_inlet_node_name": inlet,
        "air_outlet_node_name": UNIT_OUTLET,
        "nominal_capacity": capacities.backup,
    });
    let class = match heater {
        Heater::Electric => {
            coil["efficiency"] = json!(1.0);
            "Coil:Heating:Electric"
        }
        Heater::Fuel { efficiency } => {
            coil["burner_efficiency"] = json!(efficiency);
            coil["fuel_type"] = json!("NaturalGas");
            "Coil:Heating:Fuel"
        }
    };
    model.insert(class, name, coil);
    class
}

fn curves(model: &mut Model) {
    let wet_bulb_and_outdoor = [[12.78, 23.89], [21.11, 46.11]];
    biquadratic(
        model,
        "Cooling Capacity by Temperature",
        [0.766956, 0.0107756, -0.0000414703, 0.00134961, -0.000261144, 0.000457488],
        wet_bulb_and_outdoor,
    );
    biquadratic(
        model,
        "Cooling Input by Temperature",
        [0.297145, 0.0430933, -0.000748766, 0.00597727, 0.000482112, -0.000956448],
        wet_bulb_and_outdoor,
    );
    biquadratic(
        model,
        "Defrost Input",
        [DEFROST_INPUT, 0.0, 0.0, 0.0, 0.0, 0.0],
        [[-50.0, 50.0], [-50.0, 50.0]],
    );
    let outdoor = [-20.0, 20.0];
    cubic(model, "Heating Capacity by Temperature", [0.758746, 0.027626, 0.000148716, 0.0000034992], outdoor);
    cubic(model, "Heating Input by Temperature", [1.19248, -0.0300438, 0.00103745, -0.000023328], outdoor);
    let flow = [0.5, 1.5];
    cubic(model, "Cooling Capacity by Flow", [0.8, 0.2, 0.0, 0.0], flow);
    cubic(model, "Cooling Input by Flow", [1.156, -0.1816, 0.0256, 0.0], flow);
    cubic(model, "Heating Capacity by Flow", [0.84, 0.16, 0.0, 0.0], flow);
    cubic(model, "Heating Input by Flow", [1.3824, -0.4336, 0.0512, 0.0], flow);
    cubic(model, "Cycling Loss", [0.85, 0.15, 0.0, 0.0], [0.0, 1.0]);
}

/// c₁ + c₂x + c₃x² + c₄y + c₅y² + c₆xy, with the ranges of x and y.
fn biquadratic(model: &mut Model, name: &str, c: [f64; 6], [x, y]: [[f64; 2]; 2]) {
    let mut curve = coefficients(&c, &["1_constant", "2_x", "3_x_2", "4_y", "5_y_2", "6_x_y"]);
    range(&mut curve, "x", x);
    range(&mut curve, "y", y);
    model.insert("Curve:Biquadratic", name, curve);
}

/// c₁ + c₂x + c₃x² + c₄x³, with the range of x.
fn cubic(model: &mut Model, name: &str, c: [f64; 4], x: [f64; 2]) {
    let mut curve = coefficients(&c, &["1_constant", "2_x", "3_x_2", "4_x_3"]);
    range(&mut curve, "x", x);
    model.insert("Curve:Cubic", name, curve);
}

fn coefficients(values: &[f64], fields: &[&str]) -> Value {
    let pair = |(field, value)| (format!("coefficient{field}"), json!(value));
    Value::Object(fields.iter().zip(values).map(pair).collect())
}

fn range(curve: &mut Value, variable: &str, [low, high]: [f64; 2]) {
    curve[format!("minimum_value_of_{variable}")] = json!(low);
    curve[format!("maximum_value_of_{variable}")] = json!(high);
}
