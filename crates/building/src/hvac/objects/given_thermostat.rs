//! The thermostats of zones in the original model.

use crate::Model;
use crate::model::{Fields, text};
use crate::zone::covers_zone;

/// The setpoint schedules of a control type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Control {
    /// 1 heats, 2 cools, 3 holds one setpoint, 4 holds two.
    pub(crate) control_type: f64,
    /// Schedule of the heating setpoint.
    pub(crate) heating: Option<String>,
    /// Schedule of the cooling setpoint.
    pub(crate) cooling: Option<String>,
}

/// Classes of setpoints, each with its control type and the fields of its heating and its cooling schedule.
const CLASSES: [(&str, f64, Option<&str>, Option<&str>); 4] = [
    ("ThermostatSetpoint:SingleHeating", 1.0, Some("setpoint_temperature_schedule_name"), None),
    ("ThermostatSetpoint:SingleCooling", 2.0, None, Some("setpoint_temperature_schedule_name")),
    (
        "ThermostatSetpoint:SingleHeatingOrCooling",
        3.0,
        Some("setpoint_temperature_schedule_name"),
        Some("setpoint_temperature_schedule_name"),
    ),
    (
        "ThermostatSetpoint:DualSetpoint",
        4.0,
        Some("heating_setpoint_temperature_schedule_name"),
        Some("cooling_setpoint_temperature_schedule_name"),
    ),
];

/// Returns the control types of a thermostat.
pub(crate) fn controls(model: &Model, thermostat: &Fields) -> Vec<Control> {
    let control = |number: usize| {
        let class = text(thermostat, &format!("control_{number}_object_type"))?;
        let setpoints = model.get(class, text(thermostat, &format!("control_{number}_name"))?)?;
        let (_, control_type, heating, cooling) =
            CLASSES.into_iter().find(|(known, ..)| known.eq_ignore_ascii_case(class))?;
        let schedule = |field: Option<&str>| Some(text(setpoints, field?)?.to_owned());
        Some(Control { control_type, heating: schedule(heating), cooling: schedule(cooling) })
    };
    (1..=4).filter_map(control).collect()
}

/// Returns the setpoints of a zone's thermostat of stages, which sets them instead of another thermostat.
pub(crate) fn staged(model: &Model, zone: &str) -> Option<Control> {
    let mut thermostats =
        model.objects("ZoneControl:Thermostat:StagedDualSetpoint").into_iter().map(|(_, fields)| fields);
    let own = thermostats.find(|fields| {
        text(fields, "zone_or_zonelist_name").is_some_and(|zones| covers_zone(model, zones, zone))
    })?;
    let schedule = |field: &str| text(own, field).map(str::to_owned);
    Some(Control {
        control_type: 4.0,
        heating: schedule("heating_temperature_setpoint_schedule_name"),
        cooling: schedule("cooling_temperature_setpoint_base_schedule_name"),
    })
}

/// Returns the thermostat of a zone, with the zone list if it controls one.
pub(crate) fn thermostat(model: &Model, zone: &str) -> Option<(String, Option<String>)> {
    model.objects("ZoneControl:Thermostat").into_iter().find_map(|(name, fields)| {
        let zones = text(fields, "zone_or_zonelist_name").unwrap_or_default();
        if zones.eq_ignore_ascii_case(zone) {
            return Some((name.to_owned(), None));
        }
        covers_zone(model, zones, zone).then(|| (name.to_owned(), Some(zones.to_owned())))
    })
}

/// Returns whether a zone has a thermostat of any kind.
pub(in crate::hvac) fn has_thermostat(model: &Model, zone: &str) -> bool {
    let mut kinds = model.classes().filter(|class| class.starts_with("ZoneControl:Thermostat"));
    kinds.any(|class| {
        model.objects(class).into_iter().any(|(_, fields)| {
            text(fields, "zone_or_zonelist_name").is_some_and(|zones| covers_zone(model, zones, zone))
        })
    })
}
