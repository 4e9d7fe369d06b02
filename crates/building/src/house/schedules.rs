//! Schedules: those that control the house, and those of the people in it.

use serde_json::{Value, json};

use crate::Model;

/// A schedule that is 1.
pub(super) const ALWAYS: &str = "Always On";

/// The flow command of a zone, as a fraction of its terminal's design flow.
pub(super) fn supply_air_flow_fraction(zone: &str) -> String {
    format!("{zone} Supply Air Flow Fraction")
}

/// The supply air temperature command of a zone, °C.
pub(super) fn supply_air_temperature(zone: &str) -> String {
    format!("{zone} Supply Air Temperature")
}

/// The heating setpoint of a zone's thermostat, °C.
pub(super) fn heating_setpoint(zone: &str) -> String {
    format!("{zone} Heating Setpoint")
}

/// The cooling setpoint of a zone's thermostat, °C.
pub(super) fn cooling_setpoint(zone: &str) -> String {
    format!("{zone} Cooling Setpoint")
}

/// A schedule that holds a value, and that an actuator may set.
pub(super) fn constant(model: &mut Model, name: &str, value: f64) {
    model.insert("Schedule:Constant", name, json!({"hourly_value": value}));
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
    model.insert("Schedule:Compact", name, json!({"data": data}));
}

fn field(text: &str) -> Value {
    json!({"field": text})
}
