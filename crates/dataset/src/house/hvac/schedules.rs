//! Control and occupancy schedules.

use b2b_building::Model;
pub(crate) use b2b_building::hvac::thermostat::{cooling_setpoint, heating_setpoint};
pub(crate) use b2b_building::hvac::unitary::{supply_air_flow_fraction, supply_air_temperature};
use serde_json::{Value, json};

use crate::house::household::Household;

/// Values of every schedule: any number.
const ANY_NUMBER: &str = "Any Number";
/// A schedule that is 1.
pub(crate) const ALWAYS: &str = "Always On";

/// Adds the type of every schedule, and the schedule that is always 1.
pub(crate) fn add(model: &mut Model) {
    let limits = json!({"numeric_type": "Continuous"});
    model.insert("ScheduleTypeLimits", ANY_NUMBER, limits);
    constant(model, ALWAYS, 1.0);
}

/// Inserts a constant schedule, which an actuator may set.
pub(crate) fn constant(model: &mut Model, name: &str, value: f64) {
    let schedule = json!({"schedule_type_limits_name": ANY_NUMBER, "hourly_value": value});
    model.insert("Schedule:Constant", name, schedule);
}

/// Inserts a schedule of the hours of every day.
pub(crate) fn daily(model: &mut Model, name: &str, hours: &[f64; 24]) {
    let mut data = vec![field("Through: 12/31"), field("For: AllDays")];
    for (hour, value) in hours.iter().enumerate() {
        data.extend([field(&format!("Until: {:02}:00", hour + 1)), json!({"field": value})]);
    }
    compact(model, name, data);
}

/// Days of a household's week as a schedule names them, Monday first. Sunday stands for holidays and design days too.
const DAYS: [&str; 7] =
    ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday AllOtherDays"];

/// Inserts a schedule of the share of a household's people who are at home.
pub(crate) fn occupancy(model: &mut Model, name: &str, household: &Household) {
    let share = |count: u32| f64::from(count) / f64::from(household.people().max(1));
    let mut data = vec![field("Through: 12/31")];
    for (day, name) in DAYS.iter().enumerate() {
        data.push(field(&format!("For: {name}")));
        let mut end = 0;
        for equal in household.at_home(day).chunk_by(|a, b| a == b) {
            end += equal.len();
            let until = format!("Until: {:02}:{:02}", end / 4, end % 4 * 15);
            data.extend([field(&until), json!({"field": share(equal[0])})]);
        }
    }
    compact(model, name, data);
}

pub(crate) fn compact(model: &mut Model, name: &str, data: Vec<Value>) {
    let schedule = json!({"schedule_type_limits_name": ANY_NUMBER, "data": data});
    model.insert("Schedule:Compact", name, schedule);
}

pub(crate) fn field(text: &str) -> Value {
    json!({"field": text})
}
