//! The search space of a class of buildings: some parameters of its controllers, each with a range.

use b2b_building::parameter::Field;
use b2b_building::{BuildingType, Class};

use crate::ReactiveParameters;

/// A searched parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    name: &'static str,
    low: f64,
    high: f64,
    /// Whether the search is over its logarithm, as for gains and rates.
    logarithmic: bool,
}

const fn linear(name: &'static str, low: f64, high: f64) -> Axis {
    Axis { name, low, high, logarithmic: false }
}

const fn logarithmic(name: &'static str, low: f64, high: f64) -> Axis {
    Axis { name, low, high, logarithmic: true }
}

/// Parameters of unitary systems.
const UNITARY: [Axis; 8] = [
    logarithmic("unitary.gains.proportional", 0.05, 2.0),
    logarithmic("unitary.gains.integral", 0.1, 10.0),
    linear("unitary.temperature_share", 0.1, 0.9),
    linear("unitary.min_flow", 0.2, 0.8),
    linear("unitary.heating_lift", 4.0, 20.0),
    linear("unitary.cooling_drop", 3.0, 12.0),
    logarithmic("unitary.trim_respond.respond", 2.0, 50.0),
    linear("unitary.trim_respond.threshold", 0.3, 0.95),
];

/// Parameters of central air loops. The deadband is not searched: with an energy weight of 0 the search would remove it,
/// and zones would be cooled and reheated at once.
const AIR_LOOP: [Axis; 8] = [
    logarithmic("air_loop.gains.proportional", 0.1, 4.0),
    logarithmic("air_loop.gains.integral", 0.2, 20.0),
    linear("air_loop.min_opening", 0.03, 0.4),
    linear("air_loop.max_supply_temperature", 15.0, 21.0),
    logarithmic("air_loop.trim_respond.respond", 1.0, 40.0),
    logarithmic("air_loop.trim_respond.trim", 1.0, 20.0),
    linear("air_loop.trim_respond.threshold", 0.3, 0.95),
    logarithmic("air_loop.heating_gain", 0.1, 4.0),
];

/// Returns the axes of a class. All types but the medium office have unitary systems.
pub(super) fn axes(class: Class) -> &'static [Axis] {
    if class.building_type == BuildingType::OfficeMedium { &AIR_LOOP } else { &UNITARY }
}

impl Axis {
    /// Name of the parameter.
    pub(super) fn name(&self) -> &'static str {
        self.name
    }

    /// Returns the range in search coordinates.
    pub(super) fn range(&self) -> [f64; 2] {
        [self.to_search(self.low), self.to_search(self.high)]
    }

    /// Converts a value to search coordinates.
    pub(super) fn to_search(self, value: f64) -> f64 {
        let value = value.clamp(self.low, self.high);
        if self.logarithmic { value.ln() } else { value }
    }

    /// Converts a proposal of the search to a value, rounded to three digits.
    pub(super) fn to_value(self, searched: f64) -> f64 {
        let value = if self.logarithmic { searched.exp() } else { searched };
        // A number of three digits round-trips through its text.
        format!("{value:.2e}").parse().unwrap_or(value).clamp(self.low, self.high)
    }

    /// Returns the value of the parameter.
    pub(super) fn of(&self, parameters: &ReactiveParameters) -> f64 {
        self.parameter().of(parameters)
    }

    fn parameter(&self) -> Field<ReactiveParameters> {
        ReactiveParameters::parameter(self.name).expect("a test checks that every axis is a parameter")
    }
}

/// Returns the default parameters with these values on the axes.
pub(super) fn parameters(axes: &[Axis], values: &[f64]) -> ReactiveParameters {
    let mut parameters = ReactiveParameters::default();
    for (axis, value) in axes.iter().zip(values) {
        axis.parameter().set(&mut parameters, *value);
    }
    parameters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_is_a_parameter_whose_range_is_within_its_bounds() {
        for class in Class::all() {
            let axes = axes(class);
            for end in [0, 1] {
                let values: Vec<f64> = axes.iter().map(|axis| axis.to_value(axis.range()[end])).collect();
                parameters(axes, &values).check().unwrap();
            }
            let defaults: Vec<f64> =
                axes.iter().map(|axis| axis.of(&ReactiveParameters::default())).collect();
            assert_eq!(parameters(axes, &defaults), ReactiveParameters::default());
            for (axis, value) in axes.iter().zip(&defaults) {
                assert!((axis.low..=axis.high).contains(value), "{} {value}", axis.name);
                assert_eq!(axis.to_value(axis.to_search(*value)), *value, "{}", axis.name);
            }
        }
    }
}
