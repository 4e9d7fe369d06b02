//! The parameters of the reactive controllers, each with its bounds.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{AirLoopParameters, UnitaryParameters};
use crate::{Error, Result};

/// Parameters of the reactive controllers. The defaults hold 21 °C in every base building; they are not tuned to
/// any one. [`ReactiveParameters::tuned_for`] has what tuning found for a class of buildings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReactiveParameters {
    /// For unitary systems.
    pub unitary: UnitaryParameters,
    /// For central air loops.
    pub air_loop: AirLoopParameters,
}

/// One of them.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name, as in JSON with dots between the levels.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
    place: fn(&mut ReactiveParameters) -> &mut f64,
}

macro_rules! parameter {
    ($($level:ident).+, $unit:literal, $low:literal, $high:literal) => {
        Parameter {
            name: concat_names!($($level).+),
            unit: $unit,
            low: $low,
            high: $high,
            place: |parameters| &mut parameters.$($level).+,
        }
    };
}

macro_rules! concat_names {
    ($first:ident $(. $next:ident)*) => { concat!(stringify!($first) $(, ".", stringify!($next))*) };
}

impl Parameter {
    /// Every parameter.
    pub const ALL: [Self; 30] = [
        parameter!(unitary.gains.proportional, "1/K", 0.0, 10.0),
        parameter!(unitary.gains.integral, "1/(K h)", 0.0, 100.0),
        parameter!(unitary.deadband, "K", 0.0, 2.0),
        parameter!(unitary.restart_jump, "K", 0.1, 50.0),
        parameter!(unitary.temperature_share, "1", 0.05, 0.95),
        parameter!(unitary.least_flow, "1", 0.0, 1.0),
        parameter!(unitary.heating_lift, "K", 0.0, 30.0),
        parameter!(unitary.cooling_drop, "K", 0.0, 15.0),
        parameter!(unitary.trim_respond.respond, "K/h", 0.0, 100.0),
        parameter!(unitary.trim_respond.most_requests, "1", 1.0, 100.0),
        parameter!(unitary.trim_respond.trim, "K/h", 0.0, 100.0),
        parameter!(unitary.trim_respond.threshold, "1", 0.0, 1.0),
        parameter!(unitary.trim_respond.release, "1", 0.0, 1.0),
        parameter!(unitary.trim_respond.ignored, "1", 0.0, 100.0),
        parameter!(air_loop.gains.proportional, "1/K", 0.0, 10.0),
        parameter!(air_loop.gains.integral, "1/(K h)", 0.0, 100.0),
        parameter!(air_loop.restart_jump, "K", 0.1, 50.0),
        parameter!(air_loop.least_opening, "1", 0.01, 1.0),
        parameter!(air_loop.warmest_supply, "°C", 10.0, 30.0),
        parameter!(air_loop.coldest_supply, "°C", 5.0, 20.0),
        parameter!(air_loop.trim_respond.respond, "K/h", 0.0, 100.0),
        parameter!(air_loop.trim_respond.most_requests, "1", 1.0, 100.0),
        parameter!(air_loop.trim_respond.trim, "K/h", 0.0, 100.0),
        parameter!(air_loop.trim_respond.threshold, "1", 0.0, 1.0),
        parameter!(air_loop.trim_respond.release, "1", 0.0, 1.0),
        parameter!(air_loop.trim_respond.ignored, "1", 0.0, 100.0),
        parameter!(air_loop.least_outdoor_air, "1", 0.0, 1.0),
        parameter!(air_loop.fan_rise, "K", 0.0, 5.0),
        parameter!(air_loop.deadband, "K", 0.0, 2.0),
        parameter!(air_loop.heating_opening, "1/K", 0.0, 10.0),
    ];

    /// The parameter of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.name == name)
    }

    /// Its value.
    pub fn of(&self, parameters: &ReactiveParameters) -> f64 {
        *(self.place)(&mut parameters.clone())
    }

    /// Gives it a value, without a check.
    pub fn set(&self, parameters: &mut ReactiveParameters, value: f64) {
        *(self.place)(parameters) = value;
    }
}

impl ReactiveParameters {
    /// Parameters from a JSON file; what it leaves out has its default.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ParameterFile`] with what is wrong in it; those of [`ReactiveParameters::check`].
    pub fn read(path: &Path) -> Result<Self> {
        let text =
            std::fs::read_to_string(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        let parameters: Self = serde_json::from_str(&text)
            .map_err(|error| Error::ParameterFile { path: path.to_owned(), why: error.to_string() })?;
        parameters.check()?;
        Ok(parameters)
    }

    /// Whether every value is a number within the bounds of its parameter.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<()> {
        for parameter in Parameter::ALL {
            within(parameter.name, parameter.unit, parameter.of(self), parameter.low, parameter.high)?;
        }
        let AirLoopParameters { coldest_supply, warmest_supply, .. } = self.air_loop;
        within("air_loop.coldest_supply", "°C", coldest_supply, 5.0, warmest_supply)
    }
}

fn within(name: &'static str, unit: &'static str, value: f64, low: f64, high: f64) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Error::Parameter { name, value, low, high, unit })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of all numbers in a JSON object, with dots between the levels.
    fn names(value: &serde_json::Value, level: &str, found: &mut Vec<String>) {
        match value.as_object() {
            Some(object) => object.iter().for_each(|(key, value)| {
                names(value, [level, key].join(".").trim_start_matches('.'), found);
            }),
            None => found.push(level.to_owned()),
        }
    }

    #[test]
    fn every_number_has_bounds_and_the_defaults_are_within() {
        let mut found = Vec::new();
        names(&serde_json::to_value(ReactiveParameters::default()).unwrap(), "", &mut found);
        found.sort();
        let mut known: Vec<_> = Parameter::ALL.iter().map(|parameter| parameter.name.to_owned()).collect();
        known.sort();
        assert_eq!(found, known);
        ReactiveParameters::default().check().unwrap();
    }

    #[test]
    fn a_value_out_of_bounds_is_refused_by_name_value_and_bounds() {
        for parameter in Parameter::ALL {
            for value in [parameter.low - 0.1, parameter.high + 0.1, f64::NAN] {
                let mut parameters = ReactiveParameters::default();
                parameter.set(&mut parameters, value);
                let said = parameters.check().unwrap_err().to_string();
                let words = [parameter.name.to_owned(), value.to_string(), parameter.high.to_string()];
                assert!(words.iter().all(|word| said.contains(word)), "{said}");
            }
        }
        let mut crossed = ReactiveParameters::default();
        crossed.air_loop.coldest_supply = 19.0;
        assert!(crossed.check().unwrap_err().to_string().contains("coldest_supply"));
    }

    #[test]
    fn a_file_may_leave_out_what_it_does_not_change_and_no_name_may_be_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("parameters.json");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            ReactiveParameters::read(&path)
        };
        let read_back =
            read(r#"{"unitary": {"heating_lift": 12, "gains": {"proportional": 0.3, "integral": 2}}}"#);
        let read_back = read_back.unwrap();
        assert_eq!((read_back.unitary.heating_lift, read_back.unitary.gains.integral), (12.0, 2.0));
        assert_eq!(read_back.air_loop, AirLoopParameters::default());
        for (text, word) in [
            (r#"{"unitary": {"heating_lif": 12}}"#, "heating_lif"),
            (r#"{"unitary": {"least_flow": 2}}"#, "unitary.least_flow"),
        ] {
            let said = read(text).unwrap_err().to_string();
            assert!(said.contains(word), "{said}");
        }
    }
}
