//! Notes on the EMS programs that discovery removes, and on the sensors that it silences.

use crate::Model;
use crate::hvac::energy_management::{PROGRAM, Setting, has_actuator, settings, silenced_sensors};

/// The EMS programs of a model before they are changed, each with what it sets.
pub(super) struct Programs(Vec<(String, Vec<Setting>)>);

impl Programs {
    pub(super) fn of(model: &Model) -> Self {
        let programs = model.objects(PROGRAM).into_iter();
        Self(programs.map(|(name, fields)| (name.to_owned(), settings(model, fields))).collect())
    }

    /// Returns what was removed, and which sensors were silenced.
    pub(super) fn notes(&self, model: &Model) -> Vec<String> {
        let removed = self.0.iter().filter(|(name, _)| !model.contains(PROGRAM, name));
        let sensors = silenced_sensors(model);
        let sensors =
            sensors.iter().map(|sensor| format!("EMS sensor `{sensor}` reads 0: its equipment was replaced"));
        removed.map(|(name, settings)| note(model, name, settings)).chain(sensors).collect()
    }
}

/// Returns the note on a removed program. Actuators that were removed with it act on a controlled system.
fn note(model: &Model, program: &str, settings: &[Setting]) -> String {
    let (others, controlled): (Vec<_>, Vec<_>) =
        settings.iter().partition(|setting| has_actuator(model, &setting.actuator));
    let list = |settings: &[&Setting]| {
        settings.iter().map(|setting| setting.what.as_str()).collect::<Vec<_>>().join(", ")
    };
    let with_it = match &others[..] {
        [] => String::new(),
        others => format!(", and with it what it sets of others: {}", list(others)),
    };
    format!("removed EMS program `{program}`, which set {}{with_it}", list(&controlled))
}
