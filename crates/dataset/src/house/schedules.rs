//! Control and occupancy schedules.

use b2b_building::Model;
pub(super) use b2b_building::hvac::thermostat::{cooling_setpoint, heating_setpoint};
pub(super) use b2b_building::hvac::unitary::{supply_air_flow_fraction, supply_air_temperature};
use serde_json::{Value, json};

/// Values of every schedule: any number.
const ANY_NUMBER: &str = "Any Number";
/// A schedule that is 1.
pub(super) const ALWAYS: &str = "Always On";

/// What every other schedule refers to.
pub(super) fn add(model: &mut Model) {
    let limits = json!({"numeric_type": "Continuous"});
    model.insert("ScheduleTypeLimits", ANY_NUMBER, limits);
    constant(model, ALWAYS, 1.0);
}

/// Inserts a constant schedule, which an actuator may set.
pub(super) fn constant(model: &mut Model, name: &str, value: f64) {
    let schedule = json!({"schedule_type_limits_name": ANY_NUMBER, "hourly_value": value});
    model.insert("Schedule:Constant", name, schedule);
}

/// A schedule of every weekday hour and every weekend hour.
pub(super) fn daily(model: &mut Model, name: &str, weekday: &[f64; 24], weekend: &[f64; 24]) {
    let mut data = vec![field("Through: 12/31")];
    for (days, hours) in [("For: Weekdays", weekday), ("For: AllOtherDays", weekend)] {
        data.push(field(days));
        for (hour, value) in hours.iter().enumerate() {
            data.push(field(&format!("Until: {:02}:00", hour + 1)));
            data.push(json!({"field": value}));
        }
    }
    let schedule = json!({"schedule_type_limits_name": ANY_NUMBER, "data": data});
    model.insert("Schedule:Compact", name, schedule);
}

fn field(text: &str) -> Value {
    json!({"field": text})
}
