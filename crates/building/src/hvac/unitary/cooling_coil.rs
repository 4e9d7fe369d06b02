//! Two-speed cooling coils with the performance of the coils they replace.

use serde_json::{Value, json};

use crate::model::{Fields, number};

/// Performance curves with the same name in single-speed coils and in the speeds of multi-speed coils.
pub(super) const CURVES: [&str; 4] = [
    "total_cooling_capacity_function_of_temperature_curve_name",
    "total_cooling_capacity_function_of_flow_fraction_curve_name",
    "energy_input_ratio_function_of_temperature_curve_name",
    "energy_input_ratio_function_of_flow_fraction_curve_name",
];
pub(super) const PART_LOAD_CURVE: &str = "part_load_fraction_correlation_curve_name";

/// Low speed of a two-speed coil that replaces a single-speed coil: fraction of its capacity and of its air flow. Both
/// are the same, so that the flow per capacity stays in the range that the engine accepts.
const LOW_SPEED: f64 = 0.5;

/// Returns the fields of a two-speed coil with the performance of a coil of this class; `None` if there is no
/// equivalent.
///
/// Single-speed coils jump to −39 °C at low flow, multi-speed coils control the fan themselves, and variable-speed
/// coils have the wrong power below 20 % flow.
pub(super) fn two_speed_equivalent(class: &str, old: Fields) -> Option<Value> {
    match class.to_ascii_lowercase().as_str() {
        "coil:cooling:dx:singlespeed" => two_speed_from_single(&old),
        "coil:cooling:dx:multispeed" => two_speed_from_multi(&old),
        "coil:cooling:dx:twospeed" => Some(Value::Object(old)),
        _ => None,
    }
}

fn two_speed_from_single(old: &Fields) -> Option<Value> {
    let capacity = number(old, "gross_rated_total_cooling_capacity")?;
    let flow = number(old, "rated_air_flow_rate")?;
    let cop = number(old, "gross_rated_cooling_cop")?;
    let sensible = number(old, "gross_rated_sensible_heat_ratio")?;
    let high = Speed { capacity, flow, cop, sensible };
    let low = Speed { capacity: capacity * LOW_SPEED, flow: flow * LOW_SPEED, cop, sensible };
    two_speed(low, high, |curve| old.get(curve).cloned())
}

fn two_speed_from_multi(old: &Fields) -> Option<Value> {
    let speed = |n: u8| {
        Some(Speed {
            capacity: number(old, &format!("speed_{n}_gross_rated_total_cooling_capacity"))?,
            flow: number(old, &format!("speed_{n}_rated_air_flow_rate"))?,
            cop: number(old, &format!("speed_{n}_gross_rated_cooling_cop"))?,
            sensible: number(old, &format!("speed_{n}_gross_rated_sensible_heat_ratio"))?,
        })
    };
    let highest = number(old, "number_of_speeds").map_or(2, |speeds| speeds as u8);
    two_speed(speed(1)?, speed(highest)?, |curve| old.get(&format!("speed_{highest}_{curve}")).cloned())
}

/// One speed of a cooling coil: W, m³/s, and two ratios.
struct Speed {
    capacity: f64,
    flow: f64,
    cop: f64,
    sensible: f64,
}

fn two_speed(low: Speed, high: Speed, curve: impl Fn(&str) -> Option<Value>) -> Option<Value> {
    let mut coil = json!({
        "high_speed_gross_rated_total_cooling_capacity": high.capacity,
        "high_speed_rated_sensible_heat_ratio": high.sensible,
        "high_speed_gross_rated_cooling_cop": high.cop,
        "high_speed_rated_air_flow_rate": high.flow,
        "low_speed_gross_rated_total_cooling_capacity": low.capacity,
        "low_speed_gross_rated_sensible_heat_ratio": low.sensible,
        "low_speed_gross_rated_cooling_cop": low.cop,
        "low_speed_rated_air_flow_rate": low.flow,
        PART_LOAD_CURVE: curve(PART_LOAD_CURVE)?,
    });
    for name in CURVES {
        coil[name] = curve(name)?;
    }
    for name in [CURVES[0], CURVES[2]] {
        coil[format!("low_speed_{name}")] = curve(name)?;
    }
    Some(coil)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_speed_coil_gets_a_low_speed_of_half_its_capacity() {
        let mut old = json!({
            "gross_rated_total_cooling_capacity": 8000.0, "rated_air_flow_rate": 0.4,
            "gross_rated_cooling_cop": 4.0, "gross_rated_sensible_heat_ratio": 0.7, PART_LOAD_CURVE: "p",
        });
        for curve in CURVES {
            old[curve] = json!("c");
        }
        let coil = two_speed_from_single(old.as_object().unwrap()).unwrap();
        assert_eq!(coil["low_speed_gross_rated_total_cooling_capacity"], 4000.0);
        assert_eq!(coil["low_speed_rated_air_flow_rate"], 0.2);
    }
}
