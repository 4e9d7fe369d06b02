//! Infiltration and ventilation.
//!
//! Infiltration follows AIM-2 (Walker and Wilson 1998; ASHRAE Fundamentals, enhanced model):
//! Q = c · √((Cs ΔTⁿ)² + (Cw (s U)²ⁿ)²).

use b2b_building::Model;
use serde_json::json;

use crate::house::geometry::Geometry;
use crate::house::hvac::schedules;
use crate::house::parameters::House;
use crate::house::zones::{ATTIC, CRAWLSPACE, GARAGE, LIVING};

/// Pressure exponent of a house's leakage (CAN/CGSB-149.10 tests find 0.6 to 0.7).
const EXPONENT: f64 = 0.65;
/// Stack coefficient for one, two and three levels without flue, (Pa/K)ⁿ (ASHRAE Fundamentals 2005, enhanced model,
/// as in EnergyPlus's Input Output Reference, `ZoneInfiltration:FlowCoefficient`).
const STACK: [f64; 3] = [0.054, 0.078, 0.098];
/// Wind coefficient for one, two and three levels on a basement or slab, without flue, (Pa·s²/m²)ⁿ (ibid.).
const WIND: [f64; 3] = [0.156, 0.170, 0.170];
/// Wind coefficient on a crawlspace (ibid.). The value for three levels, which no house on a crawlspace has, is for
/// houses with a flue; without a flue it is 0.151.
const WIND_CRAWLSPACE: [f64; 3] = [0.128, 0.142, 0.154];
/// Shelter class 3: neighbors across the street (ibid.).
const SHELTER: f64 = 0.7;
/// Wind at eave height in suburbs over wind at a weather station (ASHRAE Fundamentals, airflow around buildings).
const EAVE_WIND: f64 = 0.615;

/// Vent area of an attic over its floor area (NBC 9.19.1.2).
const ATTIC_VENTS: f64 = 1.0 / 300.0;
/// Vent area of a crawlspace over its floor area (NBC 9.18.3.2: 0.1 m² for 50 m²).
const CRAWLSPACE_VENTS: f64 = 1.0 / 500.0;
/// Leaks of a garage, with its door, over its floor area (engineering judgment).
const GARAGE_LEAKS: f64 = 1.0 / 1000.0;
/// Stack coefficient of one level, (L/s)²/(cm⁴·K) (ASHRAE Fundamentals, basic model).
const OPENINGS_STACK: f64 = 0.000145;
/// Wind coefficient of one level in shelter class 3, (L/s)²/(cm⁴·(m/s)²) (ibid.).
const OPENINGS_WIND: f64 = 0.000174;

/// Pressure of a bathroom or kitchen exhaust fan, Pa, and its efficiency: 0.7 W per L/s (engineering judgment).
const EXHAUST_PRESSURE: f64 = 70.0;
const EXHAUST_EFFICIENCY: f64 = 0.1;

pub(crate) fn add(model: &mut Model, house: &House, geometry: &Geometry) {
    let level = level(geometry);
    let leaks = json!({
        "zone_or_space_name": LIVING,
        "schedule_name": schedules::ALWAYS,
        "flow_coefficient": flow_coefficient(house, geometry),
        "pressure_exponent": EXPONENT,
        "stack_coefficient": STACK[level],
        "wind_coefficient": wind_coefficient(geometry),
        "shelter_factor": SHELTER,
    });
    model.insert("ZoneInfiltration:FlowCoefficient", "Living Leaks", leaks);
    openings(model, ATTIC, "Attic Vents", ATTIC_VENTS * geometry.footprint());
    if geometry.crawlspace.is_some() {
        openings(model, CRAWLSPACE, "Crawlspace Vents", CRAWLSPACE_VENTS * geometry.footprint());
    }
    if geometry.garage {
        openings(model, GARAGE, "Garage Leaks", GARAGE_LEAKS * geometry.garage_block().area());
    }
    exhaust(model, house);
}

/// Infiltration at a temperature difference (K) and a wind at the weather station (m/s), m³/s.
pub(crate) fn flow(house: &House, geometry: &Geometry, difference: f64, wind: f64) -> f64 {
    let level = level(geometry);
    let stack = STACK[level] * libm::pow(difference.abs(), EXPONENT);
    let wind = wind_coefficient(geometry) * libm::pow(SHELTER * EAVE_WIND * wind, 2.0 * EXPONENT);
    flow_coefficient(house, geometry) * libm::hypot(stack, wind)
}

fn wind_coefficient(geometry: &Geometry) -> f64 {
    let table = if geometry.crawlspace.is_some() { WIND_CRAWLSPACE } else { WIND };
    table[level(geometry)]
}

/// Leakage at 1 Pa, m³/s.
fn flow_coefficient(house: &House, geometry: &Geometry) -> f64 {
    house.air_changes_50 * geometry.living_volume() / 3600.0 / libm::pow(50.0, EXPONENT)
}

fn level(geometry: &Geometry) -> usize {
    (geometry.levels as usize).clamp(1, STACK.len()) - 1
}

/// Openings of an unheated zone, their area in m².
fn openings(model: &mut Model, zone: &str, name: &str, area: f64) {
    let openings = json!({
        "zone_or_space_name": zone,
        "schedule_name": schedules::ALWAYS,
        "effective_air_leakage_area": area * 1e4,
        "stack_coefficient": OPENINGS_STACK,
        "wind_coefficient": OPENINGS_WIND,
    });
    model.insert("ZoneInfiltration:EffectiveLeakageArea", name, openings);
}

/// Fans with the flow whose heat is not recovered, and the fan energy of the whole flow. The ventilator thus recovers
/// the same share of the vapor as of the heat; real ones recover less.
fn exhaust(model: &mut Model, house: &House) {
    let flow = house.unrecovered_ventilation();
    if flow <= 0.0 {
        return;
    }
    let fans = json!({
        "zone_or_zonelist_or_space_or_spacelist_name": LIVING,
        "schedule_name": schedules::ALWAYS,
        "design_flow_rate_calculation_method": "Flow/Zone",
        "design_flow_rate": flow / 1000.0,
        "ventilation_type": "Exhaust",
        "fan_pressure_rise": EXHAUST_PRESSURE * house.ventilation / flow,
        "fan_total_efficiency": EXHAUST_EFFICIENCY,
    });
    model.insert("ZoneVentilation:DesignFlowRate", "Living Exhaust", fans);
}
