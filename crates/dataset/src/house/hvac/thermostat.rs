//! A thermostat for a house without another controller. It calls for the unit, whose fan runs while it heats or cools.
//!
//! A generated house is controlled through its supply air. Under its own controls it works like an ordinary house: its
//! people's [setpoints](b2b_building::band), a single-speed fan that cycles with the unit, and an open terminal.

use b2b_building::{Model, ZoneYear};
use serde_json::{Value, json};

use super::air_loop::{FAN, FAN_EFFICIENCY, FAN_PRESSURE, MOTOR_EFFICIENCY, UNIT};
use super::schedules;
use crate::house::zones::LIVING;

/// Days of a year.
const DAYS: u32 = 365;

/// Returns whether a model is a generated house that lacks a thermostat: its unit follows the flow of its terminal.
pub fn lacks_thermostat(model: &Model) -> bool {
    let control = model.get("AirLoopHVAC:UnitarySystem", UNIT).and_then(|unit| unit.get("control_type"));
    control.and_then(Value::as_str).is_some_and(|control| control.eq_ignore_ascii_case("SetPoint"))
        && model.get("Zone", LIVING).is_some()
        && model.get("Schedule:Constant", &schedules::supply_air_flow_fraction(LIVING)).is_some()
}

/// Puts the unit of a house under a thermostat with its people's setpoints, given the years of the zones in model
/// order.
pub fn add_thermostat(model: &mut Model, years: &[ZoneYear]) {
    let zones = model.names("Zone");
    let zones = zones.iter().zip(years);
    for (_, year) in zones.filter(|(zone, year)| *zone == LIVING && !year.is_empty()) {
        let setpoints = [schedules::heating_setpoint(LIVING), schedules::cooling_setpoint(LIVING)];
        for (name, is_heating) in setpoints.iter().zip([true, false]) {
            model.remove("Schedule:Constant", name);
            schedules::compact(model, name, days(year, is_heating));
        }
    }
    cycle(model);
}

/// Makes the unit meet the load of the thermostat.
fn cycle(model: &mut Model) {
    const OFF: &str = "Fan Cycles";
    schedules::constant(model, OFF, 0.0);
    schedules::constant(model, &schedules::supply_air_flow_fraction(LIVING), 1.0);
    for manager in model.names("SetpointManager:Scheduled") {
        model.remove("SetpointManager:Scheduled", &manager);
    }
    let Some(fan) = model.get("Fan:VariableVolume", FAN).cloned() else { return };
    model.remove("Fan:VariableVolume", FAN);
    let field = |name: &str| fan.get(name).cloned().unwrap_or(Value::Null);
    let on_off = json!({
        "availability_schedule_name": schedules::ALWAYS,
        "air_inlet_node_name": field("air_inlet_node_name"),
        "air_outlet_node_name": field("air_outlet_node_name"),
        "maximum_flow_rate": field("maximum_flow_rate"),
        "pressure_rise": FAN_PRESSURE,
        "fan_total_efficiency": FAN_EFFICIENCY,
        "motor_efficiency": MOTOR_EFFICIENCY,
        "motor_in_airstream_fraction": 1.0,
    });
    model.insert("Fan:OnOff", FAN, on_off);
    if let Some(unit) = model.get_mut("AirLoopHVAC:UnitarySystem", UNIT) {
        unit.insert("control_type".into(), json!("Load"));
        unit.insert("supply_fan_object_type".into(), json!("Fan:OnOff"));
        unit.insert("supply_air_fan_operating_mode_schedule_name".into(), json!(OFF));
    }
}

/// The fields of a compact schedule with a setpoint for every day of the year.
fn days(year: &ZoneYear, is_heating: bool) -> Vec<Value> {
    let mut data = Vec::new();
    for day in 1..=DAYS {
        let date = b2b_building::Date::of_day(day);
        data.push(schedules::field(&format!("Through: {}/{}", date.month(), date.day())));
        data.push(schedules::field("For: AllDays"));
        let spans = year.spans_of(day);
        for (index, span) in spans.iter().enumerate() {
            let until = spans.get(index + 1).map_or(24.0, |next| next.from);
            let setpoint = if is_heating { span.heating } else { span.cooling };
            let (hour, minute) = (until as u32, (until.fract() * 60.0).round() as u32);
            data.push(schedules::field(&format!("Until: {hour:02}:{minute:02}")));
            data.push(json!({"field": setpoint}));
        }
    }
    data
}
