//! The search space of a class of buildings and an objective: some parameters of its controllers, each with a range.

use b2b_building::Class;
use b2b_building::parameter::Field;

use crate::{Objective, ReactiveParameters};

/// A searched parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    name: &'static str,
    low: f64,
    high: f64,
    /// Whether the search uses its logarithm, as for gains and rates.
    logarithmic: bool,
}

const fn linear(name: &'static str, low: f64, high: f64) -> Axis {
    Axis { name, low, high, logarithmic: false }
}

const fn logarithmic(name: &'static str, low: f64, high: f64) -> Axis {
    Axis { name, low, high, logarithmic: true }
}

/// Parameters of unitary systems that affect comfort.
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

/// The same, plus parameters that affect energy: air flow down to none (while a zone is occupied, the ventilation
/// interlock sets the minimum), the deadband between heating and cooling, and the trim rate of resets.
const UNITARY_ENERGY: [Axis; 10] = [
    UNITARY[0],
    UNITARY[1],
    UNITARY[2],
    linear("unitary.min_flow", 0.0, 0.8),
    UNITARY[4],
    UNITARY[5],
    UNITARY[6],
    UNITARY[7],
    linear("unitary.deadband", 0.0, 0.5),
    logarithmic("unitary.trim_respond.trim", 2.0, 50.0),
];

/// Highest minimum opening of a damper: in the deadband of a zone, ASHRAE 90.1 (6.5.2.1, exception 2) allows 20 % of
/// its design flow.
const MAX_MIN_OPENING: f64 = 0.2;

/// Parameters of central air loops that affect comfort. The deadband is not among them: with an energy weight of 0 the
/// search would remove it, and zones would be cooled and reheated at once.
const AIR_LOOP: [Axis; 9] = [
    logarithmic("air_loop.gains.proportional", 0.1, 4.0),
    logarithmic("air_loop.gains.integral", 0.2, 20.0),
    linear("air_loop.min_opening", 0.03, MAX_MIN_OPENING),
    linear("air_loop.max_supply_temperature", 15.0, 21.0),
    linear("air_loop.min_supply_temperature", 8.0, 14.0),
    logarithmic("air_loop.trim_respond.respond", 1.0, 40.0),
    logarithmic("air_loop.trim_respond.trim", 1.0, 20.0),
    linear("air_loop.trim_respond.threshold", 0.3, 0.95),
    logarithmic("air_loop.heating_gain", 0.1, 4.0),
];

/// The same, plus parameters that affect energy: dampers down to closed, outdoor air down to none, and the deadband
/// between cooling and reheat.
const AIR_LOOP_ENERGY: [Axis; 11] = [
    AIR_LOOP[0],
    AIR_LOOP[1],
    linear("air_loop.min_opening", 0.0, MAX_MIN_OPENING),
    AIR_LOOP[3],
    AIR_LOOP[4],
    AIR_LOOP[5],
    AIR_LOOP[6],
    AIR_LOOP[7],
    AIR_LOOP[8],
    linear("air_loop.min_outdoor_air", 0.0, 0.4),
    linear("air_loop.deadband", 0.0, 0.5),
];

/// Returns whether a class has central air loops; the others have unitary systems.
pub(super) fn has_air_loops(class: Class) -> bool {
    class.building_type.data().has_air_loops
}

/// Returns the axes of a class and an objective. The ranges of the energy objective include the comfort objective's.
pub(super) fn axes(class: Class, objective: Objective) -> &'static [Axis] {
    match (has_air_loops(class), objective) {
        (true, Objective::Comfort) => &AIR_LOOP,
        (true, Objective::Energy) => &AIR_LOOP_ENERGY,
        (false, Objective::Comfort) => &UNITARY,
        (false, Objective::Energy) => &UNITARY_ENERGY,
    }
}

/// Returns parameters with little air flow and no outdoor air at low demand, from which the energy search starts.
pub(super) fn with_less_air(parameters: &ReactiveParameters) -> ReactiveParameters {
    let mut parameters = parameters.clone();
    parameters.unitary.min_flow = 0.1;
    parameters.air_loop.min_opening = 0.02;
    parameters.air_loop.min_outdoor_air = 0.0;
    parameters
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

    fn all() -> impl Iterator<Item = (Class, &'static [Axis])> {
        Class::all().flat_map(|class| Objective::ALL.map(|objective| (class, axes(class, objective))))
    }

    #[test]
    fn every_axis_is_a_parameter_whose_range_is_within_its_bounds() {
        for (_, axes) in all() {
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

    #[test]
    fn the_energy_search_contains_the_comfort_search_and_its_own_starts() {
        for class in Class::all() {
            let wide = axes(class, Objective::Energy);
            for axis in axes(class, Objective::Comfort) {
                let of_energy = wide.iter().find(|other| other.name == axis.name).unwrap();
                assert!(of_energy.low <= axis.low && axis.high <= of_energy.high, "{}", axis.name);
            }
            let start = with_less_air(&ReactiveParameters::default());
            assert!(wide.iter().all(|axis| (axis.low..=axis.high).contains(&axis.of(&start))));
        }
    }
}
