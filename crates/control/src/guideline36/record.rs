//! Decisions of the controller in the last step, by name: modes, setpoints, requests and loops.

use b2b_env::{DecisionSlot, Decisions};

use super::modes::Mode;
use super::zone::Zone;

/// A value of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Entry {
    /// [`Mode::number`](super::Mode::number).
    Mode,
    /// Supply air temperature setpoint, °C.
    SupplyTemperature,
    /// Upper end of the outdoor reset of the supply air temperature (t_max), °C.
    HighestSupplyTemperature,
    /// Requests for colder supply air.
    Requests,
    /// Whether the economizer is enabled.
    Economizer,
    /// Minimum outdoor air, kg/s.
    MinimumOutdoorAir,
}

impl Entry {
    /// The entries of an air loop.
    pub(super) const AIR_LOOP: &[Self] = &[
        Self::Mode,
        Self::SupplyTemperature,
        Self::HighestSupplyTemperature,
        Self::Requests,
        Self::Economizer,
        Self::MinimumOutdoorAir,
    ];
    /// The entries of a unit.
    pub(super) const UNIT: &[Self] = &[Self::Mode, Self::SupplyTemperature, Self::MinimumOutdoorAir];
    /// The entries of a thermostat.
    pub(super) const THERMOSTAT: &[Self] = &[Self::Mode];

    /// Returns its name, unit and states.
    fn described(self) -> (&'static str, &'static str, &'static [&'static str]) {
        match self {
            Self::Mode => ("mode", "1", Mode::NAMES),
            Self::SupplyTemperature => ("supply air temperature setpoint", "°C", &[]),
            Self::HighestSupplyTemperature => ("t_max", "°C", &[]),
            Self::Requests => ("cooling requests", "1", &[]),
            Self::Economizer => ("economizer enabled", "1", &[]),
            Self::MinimumOutdoorAir => ("minimum outdoor air", "kg/s", &[]),
        }
    }
}

/// Names and units of the values of a zone.
const ZONE: [(&str, &str); 4] = [
    ("heating setpoint in use", "°C"),
    ("cooling setpoint in use", "°C"),
    ("heating loop", "1"),
    ("cooling loop", "1"),
];

/// Adds the slots of a system and of its zones.
pub(super) fn add(record: &mut Decisions, system: &str, entries: &[Entry], zones: &[&str]) {
    for entry in entries {
        let (name, unit, states) = entry.described();
        record.add(DecisionSlot { name: format!("{system} {name}"), unit, zone: None, states });
    }
    for zone in zones {
        for (name, unit) in ZONE {
            let name = format!("{zone} {name}");
            record.add(DecisionSlot { name, unit, zone: Some((*zone).to_owned()), states: &[] });
        }
    }
}

/// Writes the values of a record.
pub(super) struct Writer<'a> {
    values: std::slice::IterMut<'a, f64>,
}

impl<'a> Writer<'a> {
    /// Returns a writer that fills the values in the order in which the slots were added.
    pub(super) fn new(record: &'a mut Decisions) -> Self {
        Self { values: record.values.iter_mut() }
    }

    /// Writes the values of a system and of its zones.
    pub(super) fn write<'z>(
        &mut self,
        entries: &[Entry],
        value: impl Fn(Entry) -> f64,
        zones: impl Iterator<Item = &'z Zone>,
    ) {
        entries.iter().for_each(|&entry| self.put(value(entry)));
        for zone in zones {
            let (setpoints, outputs) = (zone.setpoints(), zone.outputs());
            [setpoints.heating, setpoints.cooling, outputs.heating, outputs.cooling]
                .into_iter()
                .for_each(|value| self.put(value));
        }
    }

    fn put(&mut self, value: f64) {
        if let Some(slot) = self.values.next() {
            *slot = value;
        }
    }
}
