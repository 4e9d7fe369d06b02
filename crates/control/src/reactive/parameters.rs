//! Parameters of the reactive controllers, with bounds and units.

use std::path::Path;

use b2b_building::parameter::Field;
use serde::{Deserialize, Serialize};

use super::air_loop::AirLoopParameters;
use super::unitary::UnitaryParameters;
use crate::Result;
use crate::parameter_set::{self, parameter};

/// Parameters of the reactive controllers. The defaults hold 21 °C in every prototype building and are not tuned to any
/// of them. [`ReactiveParameters::tuned_for`] returns parameters tuned for a class of buildings and the objective of a
/// task.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReactiveParameters {
    /// Parameters of unitary systems.
    pub unitary: UnitaryParameters,
    /// Parameters of central air loops.
    pub air_loop: AirLoopParameters,
}

impl ReactiveParameters {
    /// All parameters. A name is the JSON keys joined by dots.
    pub const TABLE: [Field<Self>; 30] = [
        parameter!(unitary.gains.proportional, "1/K", 0.0, 10.0),
        parameter!(unitary.gains.integral, "1/(K h)", 0.0, 100.0),
        parameter!(unitary.deadband, "K", 0.0, 2.0),
        parameter!(unitary.restart_jump, "K", 0.1, 50.0),
        parameter!(unitary.temperature_share, "1", 0.05, 0.95),
        parameter!(unitary.min_flow, "1", 0.0, 1.0),
        parameter!(unitary.heating_lift, "K", 0.0, 30.0),
        parameter!(unitary.cooling_drop, "K", 0.0, 15.0),
        parameter!(unitary.trim_respond.respond, "K/h", 0.0, 100.0),
        parameter!(unitary.trim_respond.max_requests, "1", 1.0, 100.0),
        parameter!(unitary.trim_respond.trim, "K/h", 0.0, 100.0),
        parameter!(unitary.trim_respond.threshold, "1", 0.0, 1.0),
        parameter!(unitary.trim_respond.hysteresis, "1", 0.0, 1.0),
        parameter!(unitary.trim_respond.ignored_requests, "1", 0.0, 100.0),
        parameter!(air_loop.gains.proportional, "1/K", 0.0, 10.0),
        parameter!(air_loop.gains.integral, "1/(K h)", 0.0, 100.0),
        parameter!(air_loop.restart_jump, "K", 0.1, 50.0),
        parameter!(air_loop.min_opening, "1", 0.0, 1.0),
        parameter!(air_loop.max_supply_temperature, "°C", 10.0, 30.0),
        parameter!(air_loop.min_supply_temperature, "°C", 5.0, 20.0),
        parameter!(air_loop.trim_respond.respond, "K/h", 0.0, 100.0),
        parameter!(air_loop.trim_respond.max_requests, "1", 1.0, 100.0),
        parameter!(air_loop.trim_respond.trim, "K/h", 0.0, 100.0),
        parameter!(air_loop.trim_respond.threshold, "1", 0.0, 1.0),
        parameter!(air_loop.trim_respond.hysteresis, "1", 0.0, 1.0),
        parameter!(air_loop.trim_respond.ignored_requests, "1", 0.0, 100.0),
        parameter!(air_loop.min_outdoor_air, "1", 0.0, 1.0),
        parameter!(air_loop.fan_rise, "K", 0.0, 5.0),
        parameter!(air_loop.deadband, "K", 0.0, 2.0),
        parameter!(air_loop.heating_gain, "1/K", 0.0, 10.0),
    ];

    /// Returns the parameter with this name.
    pub fn parameter(name: &str) -> Option<Field<Self>> {
        Self::TABLE.into_iter().find(|field| field.parameter.name == name)
    }

    /// Sets a parameter by its name in [`ReactiveParameters::TABLE`]; [`ReactiveParameters::check`] checks its value.
    ///
    /// # Errors
    /// [`Error::UnknownParameter`](crate::Error::UnknownParameter).
    pub fn set(&mut self, name: &str, value: f64) -> Result<()> {
        parameter_set::set(self, &Self::TABLE, "the reactive controllers", name, value)
    }

    /// Returns a text that identifies the parameters. Results store its hash, which changes when a field is renamed.
    pub fn fingerprint(&self) -> String {
        format!("{self:?}")
    }

    /// Reads parameters from a JSON file; omitted fields keep their defaults.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::ParameterFile`](crate::Error::ParameterFile) with the reason; the
    /// errors of [`ReactiveParameters::check`].
    pub fn read(path: &Path) -> Result<Self> {
        let parameters: Self = parameter_set::read(path)?;
        parameters.check()?;
        Ok(parameters)
    }

    /// Checks that every value is within the bounds of its parameter, and the minimum supply air temperature at most
    /// the maximum.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for the first that is not.
    pub fn check(&self) -> Result<()> {
        let AirLoopParameters { min_supply_temperature, max_supply_temperature, .. } = self.air_loop;
        parameter_set::check(self, &Self::TABLE, [min_supply_temperature, max_supply_temperature])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of all numbers in a JSON object, keys joined by dots.
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
        let mut known: Vec<_> =
            ReactiveParameters::TABLE.iter().map(|field| field.parameter.name.to_owned()).collect();
        known.sort();
        assert_eq!(found, known);
        ReactiveParameters::default().check().unwrap();
    }

    #[test]
    fn the_fingerprint_names_every_field_with_its_value() {
        assert_eq!(
            ReactiveParameters::default().fingerprint(),
            "ReactiveParameters { unitary: UnitaryParameters { gains: Gains { proportional: 0.2, integral: 1.0 \
             }, deadband: 0.02, restart_jump: 0.5, temperature_share: 0.5, min_flow: 0.5, heating_lift: 10.0, \
             cooling_drop: 6.0, trim_respond: TrimRespond { respond: 10.0, max_requests: 1.0, trim: 10.0, \
             threshold: 0.7, hysteresis: 0.0, ignored_requests: 0.0 } }, air_loop: AirLoopParameters { gains: \
             Gains { proportional: 0.6, integral: 2.4 }, restart_jump: 0.5, min_opening: 0.1, \
             max_supply_temperature: 18.0, min_supply_temperature: 10.0, trim_respond: TrimRespond { respond: \
             6.0, max_requests: 3.0, trim: 4.0, threshold: 0.7, hysteresis: 0.1, ignored_requests: 0.0 }, \
             min_outdoor_air: 0.15, fan_rise: 1.5, deadband: 0.05, heating_gain: 0.5 } }"
        );
    }

    #[test]
    fn the_error_for_a_value_out_of_bounds_has_name_value_and_bounds() {
        for field in ReactiveParameters::TABLE {
            let parameter = field.parameter;
            for value in [parameter.low - 0.1, parameter.high + 0.1, f64::NAN] {
                let mut parameters = ReactiveParameters::default();
                field.set(&mut parameters, value);
                let said = parameters.check().unwrap_err().to_string();
                let words = [parameter.name.to_owned(), value.to_string(), parameter.high.to_string()];
                assert!(words.iter().all(|word| said.contains(word)), "{said}");
            }
        }
        let mut crossed = ReactiveParameters::default();
        crossed.air_loop.min_supply_temperature = 19.0;
        assert!(crossed.check().unwrap_err().to_string().contains("min_supply_temperature"));
    }

    #[test]
    fn a_file_may_omit_fields_but_not_misspell_them() {
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
            (r#"{"unitary": {"min_flow": 2}}"#, "unitary.min_flow"),
        ] {
            let said = read(text).unwrap_err().to_string();
            assert!(said.contains(word), "{said}");
        }
    }
}
