//! The units of BOPTEST: SI without prefixes, kelvin for temperatures and watt for power.

use b2b_env::Spaces;

/// A unit, and the conversion to it from this project's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Name as in BOPTEST's metadata.
    pub name: &'static str,
    scale: f64,
    offset: f64,
}

/// Zero of the Celsius scale, K.
pub(crate) const ZERO_CELSIUS: f64 = 273.15;

impl Unit {
    /// Returns the unit for values in a unit of this project. Energies of a step, Wh/m², become the building's mean
    /// power.
    pub fn of(unit: &'static str, spaces: &Spaces) -> Self {
        let steps_per_hour = f64::from(spaces.episode.steps_per_hour);
        let (name, scale, offset) = match unit {
            "°C" => ("K", 1.0, ZERO_CELSIUS),
            "h" => ("s", 3600.0, 0.0),
            "%" => ("1", 0.01, 0.0),
            "Wh/m²" => ("W", spaces.building.conditioned_floor_area * steps_per_hour, 0.0),
            "W/m²" => ("W/m2", 1.0, 0.0),
            other => (other, 1.0, 0.0),
        };
        Self { name, scale, offset }
    }

    /// Returns a value in this unit.
    pub fn express(self, value: f64) -> f64 {
        value * self.scale + self.offset
    }

    /// Returns a value in the project's unit.
    pub fn own(self, value: f64) -> f64 {
        (value - self.offset) / self.scale
    }
}
