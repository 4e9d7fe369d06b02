//! Outcomes of a set of parameters on the cells of a plan, and the losses that follow from them.

use b2b_env::Metrics;
use serde::{Deserialize, Serialize};

use super::plan::Plan;

/// The outcome in a cell: sums over the episodes of a building under one setpoint mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Temperature penalty, summed over the episodes, K².
    pub temperature_penalty: f64,
    /// HVAC energy, Wh/m².
    pub energy: f64,
    /// Steps.
    pub steps: usize,
    /// Actuator travel, full strokes/day, averaged over the actuators, in the episode with the most.
    pub daily_travel: f64,
}

/// Actuator travel above which actuators hunt, full strokes/day, unless it is higher under the reference. A target that
/// jumps up and down once a day moves an actuator there and back twice: four strokes.
const MAX_TRAVEL: f64 = 5.0;

/// Returns the actuator travel above which actuators hunt, full strokes/day, given that of a reference under the same
/// conditions: 5, or that of the reference if it is higher.
pub fn travel_limit(reference: f64) -> f64 {
    reference.max(MAX_TRAVEL)
}

impl Outcome {
    /// Sums up the metrics of some episodes.
    pub fn of(episodes: &[Metrics]) -> Self {
        episodes.iter().fold(Self::default(), |sum, metrics| Self {
            temperature_penalty: sum.temperature_penalty + metrics.temperature_penalty,
            energy: sum.energy + metrics.electricity + metrics.gas,
            steps: sum.steps + metrics.steps,
            daily_travel: sum.daily_travel.max(metrics.daily_travel()),
        })
    }

    /// Returns the loss per step: the negated return of the objective's task.
    pub(super) fn loss(&self, plan: &Plan) -> f64 {
        let energy = plan.objective.energy_weight() / plan.energy_scale.unwrap_or(1.0) * self.energy;
        (self.temperature_penalty + energy) / self.steps.max(1) as f64
    }

    /// Returns the actuator travel relative to the limit, given the outcome of the defaults in the same cell.
    fn relative_travel(&self, default: &Self) -> f64 {
        self.daily_travel / travel_limit(default.daily_travel)
    }
}

/// Returns the loss of each cell relative to that of the defaults.
pub(super) fn relative_losses(plan: &Plan, defaults: &[Outcome], outcomes: &[Outcome]) -> Vec<f64> {
    let relative = |(outcome, default): (&Outcome, &Outcome)| {
        outcome.loss(plan) / default.loss(plan).max(f64::MIN_POSITIVE)
    };
    outcomes.iter().zip(defaults).map(relative).collect()
}

/// Returns the actuator travel relative to the limit in the worst of the given cells.
pub(super) fn worst_travel(defaults: &[Outcome], outcomes: &[Outcome]) -> f64 {
    let relative = outcomes.iter().zip(defaults).map(|(outcome, default)| outcome.relative_travel(default));
    relative.fold(0.0, f64::max)
}

/// Returns whether the actuators hunt in no cell. A mean over buildings would hide one that does.
pub(super) fn is_within_travel_limit(defaults: &[Outcome], outcomes: &[Outcome]) -> bool {
    worst_travel(defaults, outcomes) <= 1.0
}

/// Returns the factor on the loss of a set of parameters under which actuators hunt: the square of the travel relative to
/// the limit, on the worst building.
pub(super) fn travel_factor(defaults: &[Outcome], outcomes: &[Outcome]) -> f64 {
    worst_travel(defaults, outcomes).max(1.0).powi(2)
}

/// Returns the 75th percentile of relative losses, interpolated between neighbors. With five buildings, this is the second
/// worst: a set has to be good on all but one.
pub(super) fn percentile_75(losses: &[f64]) -> f64 {
    let mut sorted = losses.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = 0.75 * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + place.fract() * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_percentile_of_five_buildings_is_the_second_worst() {
        assert_eq!(percentile_75(&[2.0, 1.0, 0.5, 0.5, 0.4]), 1.0);
        assert_eq!(percentile_75(&[1.0, 3.0]), 2.5);
        assert_eq!(percentile_75(&[0.7]), 0.7);
    }

    #[test]
    fn travel_is_limited_on_the_worst_building_unless_the_defaults_travel_more() {
        let outcomes =
            |travel: [f64; 2]| travel.map(|daily_travel| Outcome { daily_travel, ..Outcome::default() });
        let defaults = outcomes([1.0, 8.0]);
        assert!(is_within_travel_limit(&defaults, &outcomes([5.0, 8.0])));
        assert!(
            !is_within_travel_limit(&defaults, &outcomes([0.0, 8.1]))
                && !is_within_travel_limit(&defaults, &outcomes([5.1, 0.0]))
        );
        assert_eq!(travel_factor(&defaults, &outcomes([4.0, 4.0])), 1.0);
        assert_eq!(travel_factor(&defaults, &outcomes([10.0, 0.0])), 4.0);
    }
}
