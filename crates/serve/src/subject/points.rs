//! The points of a test case: its inputs are the actuators, its measurements the slots of the observation.

use std::collections::HashSet;

use b2b_env::Spaces;
use serde_json::{Map, Value, json};

use super::units::Unit;

/// An input: `NAME_u` sets an actuator while `NAME_activate` is 1.
#[derive(Clone, Debug)]
pub(crate) struct Input {
    /// Name of its value, which ends with `_u`.
    pub value: String,
    /// Name of its activation, which ends with `_activate`.
    pub activation: String,
    /// Unit of the value.
    pub unit: Unit,
    /// Bounds of the value.
    pub bounds: [f64; 2],
    description: String,
}

/// A measurement, whose name ends with `_y`.
#[derive(Clone, Debug)]
pub(crate) struct Measurement {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: Unit,
    description: String,
}

/// The points of a building, in the order of its action and its observation.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// One for each actuator.
    pub inputs: Vec<Input>,
    /// One for each slot.
    pub measurements: Vec<Measurement>,
}

impl Points {
    /// Returns the points of a building under a task with bands.
    pub fn of(spaces: &Spaces) -> Self {
        let mut names = Names::default();
        let action = &spaces.action;
        let actuators = action.names().iter().zip(action.quantities());
        let bounds = action.low().iter().zip(action.high());
        let inputs = actuators.zip(bounds).map(|((name, quantity), (low, high))| {
            let unit = Unit::of(quantity.unit(), spaces);
            let point = names.unique(name);
            Input {
                value: format!("{point}_u"),
                activation: format!("{point}_activate"),
                bounds: [unit.express(*low), unit.express(*high)],
                unit,
                description: name.clone(),
            }
        });
        let inputs = inputs.collect();
        let mut names = Names::default();
        let measurements = spaces.observation.slots().iter().map(|slot| {
            let unit = Unit::of(slot.unit, spaces);
            let mean = if slot.unit == "Wh/m²" { ", mean of the last control step" } else { "" };
            let description = format!("{}{mean} ({})", slot.name, slot.source);
            Measurement { name: format!("{}_y", names.unique(&slot.name)), unit, description }
        });
        Self { inputs, measurements: measurements.collect() }
    }

    /// Returns the inputs with their metadata.
    pub fn inputs_payload(&self) -> Value {
        let mut payload = Map::new();
        for Input { value, activation, unit, bounds: [low, high], description } in &self.inputs {
            let about = json!({
                "Unit": unit.name, "Description": description, "Minimum": low, "Maximum": high,
            });
            payload.insert(value.clone(), about);
            let description = format!("Activation of {description}");
            let about = json!({
                "Unit": null, "Description": description, "Minimum": null, "Maximum": null,
            });
            payload.insert(activation.clone(), about);
        }
        Value::Object(payload)
    }

    /// Returns the measurements with their metadata.
    pub fn measurements_payload(&self) -> Value {
        let about = |point: &Measurement| {
            let about = json!({
                "Unit": point.unit.name, "Description": point.description, "Minimum": null, "Maximum": null,
            });
            (point.name.clone(), about)
        };
        Value::Object(self.measurements.iter().map(about).collect())
    }
}

/// Names made of letters, digits and underscores, each used once.
#[derive(Default)]
pub(super) struct Names(HashSet<String>);

impl Names {
    pub(super) fn unique(&mut self, text: &str) -> String {
        let name = point_name(text);
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut candidates = std::iter::once(name.clone()).chain(numbered);
        let unused = candidates.find(|candidate| !self.0.contains(candidate)).unwrap_or(name);
        self.0.insert(unused.clone());
        unused
    }
}

/// Returns a name of letters, digits and underscores. It has no `_u`, which boptest-gym replaces wherever it stands.
pub(crate) fn point_name(text: &str) -> String {
    let letter = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
    text.chars().map(letter).collect::<String>().replace("_u", "_U")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_letters_digits_and_underscores_and_no_second_ending() {
        assert_eq!(point_name("Core_ZN supply air flow"), "Core_ZN_supply_air_flow");
        assert_eq!(point_name("Süd-1 unit heater"), "S_d_1_Unit_heater");
    }

    #[test]
    fn names_that_become_equal_are_numbered() {
        let mut names = Names::default();
        assert_eq!(["a b", "a_b", "a-b"].map(|text| names.unique(text)), ["a_b", "a_b_2", "a_b_3"]);
    }
}
