//! The thermostat of a zone in the original model.

use super::schedules::Sampled;
use crate::Model;
use crate::hvac::thermostat;
use crate::model::text;

/// The schedules of a zone's thermostat.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Thermostat {
    /// Schedule of the control type: 0 is none, 1 heats, 2 cools, 3 holds one setpoint, 4 holds two.
    control_type: String,
    /// The setpoints of each control type.
    controls: Vec<Control>,
}

/// The setpoint schedules of a control type.
#[derive(Clone, Debug, PartialEq)]
struct Control {
    control_type: f64,
    heating: Option<String>,
    cooling: Option<String>,
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

impl Thermostat {
    /// Returns the thermostat of a zone, if it has one.
    pub(super) fn of(model: &Model, zone: &str) -> Option<Self> {
        let (name, _) = thermostat::thermostat(model, zone)?;
        let fields = model.get("ZoneControl:Thermostat", &name)?;
        let control_type = text(fields, "control_type_schedule_name")?.to_owned();
        let control = |number: usize| {
            let class = text(fields, &format!("control_{number}_object_type"))?;
            let setpoints = model.get(class, text(fields, &format!("control_{number}_name"))?)?;
            let (_, control_type, heating, cooling) =
                CLASSES.into_iter().find(|(known, ..)| known.eq_ignore_ascii_case(class))?;
            let schedule = |field: Option<&str>| Some(text(setpoints, field?)?.to_owned());
            Some(Control { control_type, heating: schedule(heating), cooling: schedule(cooling) })
        };
        Some(Self { control_type, controls: (1..=4).filter_map(control).collect() })
    }

    /// Returns the names of its schedules.
    pub(super) fn schedules(&self) -> impl Iterator<Item = &str> {
        let setpoints = self.controls.iter().flat_map(|control| [&control.heating, &control.cooling]);
        setpoints.flatten().map(String::as_str).chain([self.control_type.as_str()])
    }

    /// Returns the heating and the cooling setpoint (°C) as a function of the time of the year.
    pub(super) fn setpoints<'a>(&self, sampled: &'a Sampled) -> impl Fn(usize) -> [Option<f64>; 2] + use<'a> {
        let control_type = sampled.of_schedule(&self.control_type);
        let of = |schedule: &Option<String>| Some(sampled.of_schedule(schedule.as_ref()?));
        let controls: Vec<_> = self
            .controls
            .iter()
            .map(|control| (control.control_type, [of(&control.heating), of(&control.cooling)]))
            .collect();
        move |index| {
            let active = control_type.at(index);
            let control = controls.iter().find(|(control_type, _)| *control_type == active);
            control.map_or([None; 2], |(_, setpoints)| setpoints.map(|values| Some(values?.at(index))))
        }
    }
}
