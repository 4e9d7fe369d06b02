//! Air that enters by itself and by the exhaust fans.
//!
//! The house leaks as AIM-2 says (Walker and Wilson 1998; ASHRAE Fundamentals, enhanced model):
//! Q = c · √((Cs ΔTⁿ)² + (Cw (s U)²ⁿ)²).

use serde_json::json;

use super::{ATTIC, Geometry, House, LIVING, schedules};
use crate::Model;

/// Pressure exponent of a house's leakage (CAN/CGSB-149.10 tests find 0.6 to 0.7).
const EXPONENT: f64 = 0.65;
/// Stack coefficient for one, two and three levels without flue, (Pa/K)ⁿ (ASHRAE Fundamentals, enhanced model).
const STACK: [f64; 3] = [0.054, 0.078, 0.098];
/// Wind coefficient for one, two and three levels on a basement or slab, without flue, (Pa·s²/m²)ⁿ (ibid.).
const WIND: [f64; 3] = [0.156, 0.170, 0.170];
/// Shelter class 3: neighbours across the street (ibid.).
const SHELTER: f64 = 0.7;
/// Wind at eave height in suburbs over wind at a weather station (ASHRAE Fundamentals, airflow around buildings).
const EAVE_WIND: f64 = 0.615;

/// Vent area of an attic over its floor area (NBC 9.19.1.2).
const ATTIC_VENTS: f64 = 1.0 / 300.0;
/// Stack coefficient of one level, (L/s)²/(cm⁴·K) (ASHRAE Fundamentals, basic model).
const ATTIC_STACK: f64 = 0.000145;
/// Wind coefficient of one level in shelter class 3, (L/s)²/(cm⁴·(m/s)²) (ibid.).
const ATTIC_WIND: f64 = 0.000174;

/// Pressure of a bathroom or kitchen exhaust fan, Pa, and its efficiency: 0.7 W per L/s (engineering judgement).
const EXHAUST_PRESSURE: f64 = 70.0;
const EXHAUST_EFFICIENCY: f64 = 0.1;

pub(super) fn add(model: &mut Model, house: &House, geometry: &Geometry) {
    let level = level(geometry);
    let leaks = json!({
        "zone_or_space_name": LIVING,
        "schedule_name": schedules::ALWAYS,
        "flow_coefficient": flow_coefficient(house, geometry),
        "pressure_exponent": EXPONENT,
        "stack_coefficient": STACK[level],
        "wind_coefficient": WIND[level],
        "shelter_factor": SHELTER,
    });
    model.insert("ZoneInfiltration:FlowCoefficient", "Living Leaks", leaks);
    attic(model, geometry);
    exhaust(model, house);
}

/// Infiltration at a temperature difference (K) and a wind at the weather station (m/s), m³/s.
pub(super) fn flow(house: &House, geometry: &Geometry, difference: f64, wind: f64) -> f64 {
    let level = level(geometry);
    let stack = STACK[level] * difference.abs().powf(EXPONENT);
    let wind = WIND[level] * (SHELTER * EAVE_WIND * wind).powf(2.0 * EXPONENT);
    flow_coefficient(house, geometry) * stack.hypot(wind)
}

/// Leakage at 1 Pa, m³/s.
fn flow_coefficient(house: &House, geometry: &Geometry) -> f64 {
    house.air_changes_50 * geometry.living_volume() / 3600.0 / 50f64.powf(EXPONENT)
}

fn level(geometry: &Geometry) -> usize {
    (geometry.levels as usize).clamp(1, STACK.len()) - 1
}

fn attic(model: &mut Model, geometry: &Geometry) {
    let vents = json!({
        "zone_or_space_name": ATTIC,
        "schedule_name": schedules::ALWAYS,
        "effective_air_leakage_area": ATTIC_VENTS * geometry.footprint() * 1e4,
        "stack_coefficient": ATTIC_STACK,
        "wind_coefficient": ATTIC_WIND,
    });
    model.insert("ZoneInfiltration:EffectiveLeakageArea", "Attic Vents", vents);
}

fn exhaust(model: &mut Model, house: &House) {
    if house.ventilation <= 0.0 {
        return;
    }
    let fans = json!({
        "zone_or_zonelist_or_space_or_spacelist_name": LIVING,
        "schedule_name": schedules::ALWAYS,
        "design_flow_rate_calculation_method": "Flow/Zone",
        "design_flow_rate": house.ventilation / 1000.0,
        "ventilation_type": "Exhaust",
        "fan_pressure_rise": EXHAUST_PRESSURE,
        "fan_total_efficiency": EXHAUST_EFFICIENCY,
    });
    model.insert("ZoneVentilation:DesignFlowRate", "Living Exhaust", fans);
}
