//! Notes on what discovery changes in a model's thermostats.

use crate::Model;
use crate::hvac::energy_management::schedule_sensors;
use crate::hvac::given_thermostat::{controls, thermostat};
use crate::hvac::system::System;
use crate::hvac::zone_controls::ZoneControls;

/// The thermostats of a model before they are changed.
pub(super) struct Thermostats {
    controls: ZoneControls,
    /// EMS sensors that read the setpoint of several zones.
    shared: Vec<Shared>,
}

/// An EMS sensor that reads a schedule of setpoints.
struct Shared {
    sensor: String,
    schedule: String,
    zones: Vec<String>,
}

impl Thermostats {
    pub(super) fn of(model: &Model) -> Self {
        let zones = model.names("Zone");
        let shared = |(sensor, schedule): (String, String)| {
            let zones: Vec<String> =
                zones.iter().filter(|zone| reads(model, zone, &schedule)).cloned().collect();
            (zones.len() > 1).then_some(Shared { sensor, schedule, zones })
        };
        let shared = schedule_sensors(model).into_iter().filter_map(shared).collect();
        Self { controls: ZoneControls::of(model), shared }
    }

    /// Returns what was changed.
    pub(super) fn notes(&self, model: &Model, systems: &[Box<dyn System>]) -> Vec<String> {
        let sensors = schedule_sensors(model);
        let note = |Shared { sensor, schedule, zones }: &Shared| {
            let (_, read) = sensors.iter().find(|(name, _)| name == sensor)?;
            let followed = zones.iter().find(|zone| reads(model, zone, read))?;
            let is_controlled = |zone: &&String| {
                systems.iter().any(|s| s.zones().iter().any(|other| other.eq_ignore_ascii_case(zone)))
            };
            let others: Vec<&str> = zones
                .iter()
                .filter(|zone| *zone != followed)
                .filter(is_controlled)
                .map(String::as_str)
                .collect();
            let is_changed = !read.eq_ignore_ascii_case(schedule) && !others.is_empty();
            is_changed.then(|| {
                format!(
                    "EnergyManagementSystem:Sensor `{sensor}` read schedule `{schedule}`, the setpoint of several zones; it \
                     reads the setpoint of `{followed}` now, not of {}",
                    others.iter().map(|zone| format!("`{zone}`")).collect::<Vec<_>>().join(", ")
                )
            })
        };
        self.controls.lost(model).into_iter().chain(self.shared.iter().filter_map(note)).collect()
    }
}

/// Returns whether a schedule is a setpoint of a zone.
fn reads(model: &Model, zone: &str, schedule: &str) -> bool {
    let Some(fields) =
        thermostat(model, zone).and_then(|(name, _)| model.get("ZoneControl:Thermostat", &name))
    else {
        return false;
    };
    let controls = controls(model, fields);
    let schedules = controls.iter().flat_map(|control| [&control.heating, &control.cooling]);
    schedules.flatten().any(|name| name.eq_ignore_ascii_case(schedule))
}
