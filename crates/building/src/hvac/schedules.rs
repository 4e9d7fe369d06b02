//! The schedules that edits add to a model.

use serde_json::json;

use crate::Model;

/// Schedule that is always 1.
pub const ALWAYS_ON: &str = "B2B Always On";
/// Type limits of the schedules that an agent drives: any number, because bounds are the agent's.
const ANY_NUMBER: &str = "B2B Any Number";

/// Puts a `Schedule:Constant` in: the kind of schedule that an actuator sets.
pub fn constant_schedule(model: &mut Model, name: &str, value: f64) {
    model.insert("ScheduleTypeLimits", ANY_NUMBER, json!({}));
    let fields = json!({"hourly_value": value, "schedule_type_limits_name": ANY_NUMBER});
    model.insert("Schedule:Constant", name, fields);
}
