//! The schedules that edits add to a model.

use serde_json::json;

use crate::Model;

/// Schedule that is always 1.
pub const ALWAYS_ON: &str = "B2B Always On";
/// Type limits of controlled schedules: any number, because bounds are enforced on the action.
const ANY_NUMBER: &str = "B2B Any Number";

/// Inserts a `Schedule:Constant`, the kind of schedule that actuators set.
pub fn constant_schedule(model: &mut Model, name: &str, value: f64) {
    model.insert("ScheduleTypeLimits", ANY_NUMBER, json!({}));
    let fields = json!({"hourly_value": value, "schedule_type_limits_name": ANY_NUMBER});
    model.insert("Schedule:Constant", name, fields);
}
