//! What tuning searches: a few parameters of the controllers that a class of buildings has, each within a range.

use b2b_building::{BuildingType, Class};

use crate::{Parameter, ReactiveParameters};

/// One of the parameters that are searched.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    name: &'static str,
    low: f64,
    high: f64,
    /// Whether it is searched by its logarithm, as gains and rates are.
    logarithmic: bool,
}

const fn even(name: &'static str, low: f64, high: f64) -> Axis {
    Axis { name, low, high, logarithmic: false }
}

const fn logarithmic(name: &'static str, low: f64, high: f64) -> Axis {
    Axis { name, low, high, logarithmic: true }
}

/// Of unitary systems.
const UNITARY: [Axis; 8] = [
    logarithmic("unitary.gains.proportional", 0.05, 2.0),
    logarithmic("unitary.gains.integral", 0.1, 10.0),
    even("unitary.temperature_share", 0.1, 0.9),
    even("unitary.least_flow", 0.2, 0.8),
    even("unitary.heating_lift", 4.0, 20.0),
    even("unitary.cooling_drop", 3.0, 12.0),
    logarithmic("unitary.trim_respond.respond", 2.0, 50.0),
    even("unitary.trim_respond.threshold", 0.3, 0.95),
];

/// Of central air loops. The deadband stays as it is: where energy counts for nothing, the search would take it away and
/// have zones cooled and reheated at once.
const AIR_LOOP: [Axis; 8] = [
    logarithmic("air_loop.gains.proportional", 0.1, 4.0),
    logarithmic("air_loop.gains.integral", 0.2, 20.0),
    even("air_loop.least_opening", 0.03, 0.4),
    even("air_loop.warmest_supply", 15.0, 21.0),
    logarithmic("air_loop.trim_respond.respond", 1.0, 40.0),
    logarithmic("air_loop.trim_respond.trim", 1.0, 20.0),
    even("air_loop.trim_respond.threshold", 0.3, 0.95),
    logarithmic("air_loop.heating_opening", 0.1, 4.0),
];

/// The axes for a class: every type but the medium office has unitary systems.
pub(super) fn axes(class: Class) -> &'static [Axis] {
    if class.building_type == BuildingType::OfficeMedium { &AIR_LOOP } else { &UNITARY }
}

impl Axis {
    pub(super) fn name(&self) -> &'static str {
        self.name
    }

    /// Ends of what is searched, as the search sees it.
    pub(super) fn range(&self) -> [f64; 2] {
        [self.to_search(self.low), self.to_search(self.high)]
    }

    /// A value as the search sees it.
    pub(super) fn to_search(self, value: f64) -> f64 {
        let value = value.clamp(self.low, self.high);
        if self.logarithmic { value.ln() } else { value }
    }

    /// The value of what the search proposes, in three digits.
    pub(super) fn to_value(self, searched: f64) -> f64 {
        let value = if self.logarithmic { searched.exp() } else { searched };
        // A number of three digits reads back as it prints.
        format!("{value:.2e}").parse().unwrap_or(value).clamp(self.low, self.high)
    }

    /// Its value among parameters.
    pub(super) fn of(&self, parameters: &ReactiveParameters) -> f64 {
        self.parameter().of(parameters)
    }

    fn parameter(&self) -> Parameter {
        Parameter::named(self.name).expect("a test holds the axes to the parameters")
    }
}

/// The default parameters with these values on the axes.
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
    fn every_axis_is_a_parameter_and_what_it_gives_is_within_bounds() {
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
