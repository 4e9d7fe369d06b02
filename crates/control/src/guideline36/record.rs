//! What the controller decided in the last step, by name: modes, setpoints, requests and loops.

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
    /// The entries of a heater.
    pub(super) const HEATER: &[Self] = &[Self::Mode];

    fn name(self) -> &'static str {
        match self {
            Self::Mode => "mode",
            Self::SupplyTemperature => "supply air temperature setpoint",
            Self::HighestSupplyTemperature => "t_max",
            Self::Requests => "cooling requests",
            Self::Economizer => "economizer enabled",
            Self::MinimumOutdoorAir => "minimum outdoor air",
        }
    }
}

/// Names of the values of a zone.
const ZONE: [&str; 4] =
    ["heating setpoint in use", "cooling setpoint in use", "heating loop", "cooling loop"];

/// Names and values, in a fixed order.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    names: Vec<String>,
    values: Vec<f64>,
}

impl Record {
    /// Adds the values of a system and of its zones.
    pub(super) fn add(&mut self, system: &str, entries: &[Entry], zones: &[&str]) {
        self.names.extend(entries.iter().map(|entry| format!("{system} {}", entry.name())));
        let of_zone = |zone: &&str| ZONE.map(|name| format!("{zone} {name}"));
        self.names.extend(zones.iter().flat_map(of_zone));
        self.values.resize(self.names.len(), 0.0);
    }

    /// Returns a writer that fills the values in the order in which they were added.
    pub(super) fn writer(&mut self) -> Writer<'_> {
        Writer { values: self.values.iter_mut() }
    }

    /// Returns the names with their values.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.names.iter().map(String::as_str).zip(self.values.iter().copied())
    }
}

/// Writes the values of a record.
pub(super) struct Writer<'a> {
    values: std::slice::IterMut<'a, f64>,
}

impl Writer<'_> {
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
