//! The thermostat of a zone in the original model.

use super::schedules::Sampled;
use crate::Model;
use crate::hvac::given_thermostat::{Control, controls, staged, thermostat};
use crate::model::text;

/// The schedules of a zone's thermostat.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Thermostat {
    /// Schedule of the control type: 0 is none, 1 heats, 2 cools, 3 holds one setpoint, 4 holds two. A thermostat of
    /// stages has none and always holds two.
    control_type: Option<String>,
    /// The setpoints of each control type.
    controls: Vec<Control>,
}

impl Thermostat {
    /// Returns the thermostat of a zone, if it has one.
    pub(super) fn of(model: &Model, zone: &str) -> Option<Self> {
        if let Some(control) = staged(model, zone) {
            return Some(Self { control_type: None, controls: vec![control] });
        }
        let (name, _) = thermostat(model, zone)?;
        let fields = model.get("ZoneControl:Thermostat", &name)?;
        let control_type = text(fields, "control_type_schedule_name")?.to_owned();
        Some(Self { control_type: Some(control_type), controls: controls(model, fields) })
    }

    /// Returns the names of its schedules.
    pub(super) fn schedules(&self) -> impl Iterator<Item = &str> {
        let setpoints = self.controls.iter().flat_map(|control| [&control.heating, &control.cooling]);
        setpoints.chain([&self.control_type]).flatten().map(String::as_str)
    }

    /// Returns the heating and the cooling setpoint (°C) as a function of the time of the year.
    pub(super) fn setpoints<'a>(&self, sampled: &'a Sampled) -> impl Fn(usize) -> [Option<f64>; 2] + use<'a> {
        let control_type = self.control_type.as_ref().map(|name| sampled.of_schedule(name));
        let of = |schedule: &Option<String>| Some(sampled.of_schedule(schedule.as_ref()?));
        let controls: Vec<_> = self
            .controls
            .iter()
            .map(|control| (control.control_type, [of(&control.heating), of(&control.cooling)]))
            .collect();
        move |index| {
            let active = control_type.map(|control_type| control_type.at(index));
            let control =
                controls.iter().find(|(control_type, _)| active.is_none_or(|active| active == *control_type));
            control.map_or([None; 2], |(_, setpoints)| setpoints.map(|values| Some(values?.at(index))))
        }
    }
}
