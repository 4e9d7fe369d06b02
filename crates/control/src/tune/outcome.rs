//! Outcomes of a set of parameters on the cells of a plan, and the losses that follow from them.

use b2b_env::{Metrics, Term};
use serde::{Deserialize, Serialize};

use super::limits::Limits;
use super::plan::TuningPlan;

/// The outcome in a cell: sums over the episodes of a building under one setpoint mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellOutcome {
    /// Temperature penalty, summed over the episodes.
    pub temperature_penalty: f64,
    /// HVAC energy, Wh/m².
    pub energy: f64,
    /// Steps.
    pub steps: usize,
    /// Largest actuator travel of an episode, averaged over the actuators, full strokes/day.
    pub daily_travel: f64,
}

/// Deviation below which a larger loss does not count as worse, K: the accuracy of an air temperature sensor.
const RESOLUTION: f64 = 0.2;

/// Returns the actuator travel above which actuators hunt, full strokes/day: 5, or the travel of a reference under the
/// same conditions if it is higher.
pub fn travel_limit(reference: f64) -> f64 {
    reference.max(Limits::UNITARY.travel)
}

impl CellOutcome {
    /// Sums up the metrics of some episodes.
    pub fn of(episodes: &[Metrics]) -> Self {
        episodes.iter().fold(Self::default(), |sum, metrics| Self {
            temperature_penalty: sum.temperature_penalty + metrics.temperature_penalty,
            energy: sum.energy + metrics.total(Term::Electricity) + metrics.total(Term::Gas),
            steps: sum.steps + metrics.steps,
            daily_travel: sum.daily_travel.max(metrics.daily_travel()),
        })
    }

    /// Returns the loss per step: the negated return of the objective's task.
    pub(super) fn loss(&self, plan: &TuningPlan) -> f64 {
        let energy = plan.objective.energy_weight() / plan.energy_scale.unwrap_or(1.0) * self.energy;
        (self.temperature_penalty + energy) / self.steps.max(1) as f64
    }
}

/// Returns the loss of each cell relative to the defaults' loss, after adding the resolution of a sensor to both.
pub(super) fn resolved_losses(
    plan: &TuningPlan,
    defaults: &[CellOutcome],
    outcomes: &[CellOutcome],
) -> Vec<f64> {
    let floor = RESOLUTION * RESOLUTION;
    let relative = |(outcome, default): (&CellOutcome, &CellOutcome)| {
        (outcome.loss(plan) + floor) / (default.loss(plan) + floor)
    };
    outcomes.iter().zip(defaults).map(relative).collect()
}

/// Returns the loss of each cell relative to the defaults' loss.
pub(super) fn relative_losses(
    plan: &TuningPlan,
    defaults: &[CellOutcome],
    outcomes: &[CellOutcome],
) -> Vec<f64> {
    let relative = |(outcome, default): (&CellOutcome, &CellOutcome)| {
        outcome.loss(plan) / default.loss(plan).max(f64::MIN_POSITIVE)
    };
    outcomes.iter().zip(defaults).map(relative).collect()
}

/// Returns the actuator travel relative to the limit in the worst of the given cells.
pub(super) fn worst_travel(limits: Limits, defaults: &[CellOutcome], outcomes: &[CellOutcome]) -> f64 {
    let relative = |(outcome, default): (&CellOutcome, &CellOutcome)| {
        outcome.daily_travel / default.daily_travel.max(limits.travel)
    };
    outcomes.iter().zip(defaults).map(relative).fold(0.0, f64::max)
}

/// Returns the resolved loss relative to the limit in the worst of the given cells.
pub(super) fn worst_loss(
    limits: Limits,
    plan: &TuningPlan,
    defaults: &[CellOutcome],
    outcomes: &[CellOutcome],
) -> f64 {
    resolved_losses(plan, defaults, outcomes).into_iter().fold(0.0, f64::max) / (1.0 + limits.increase)
}

/// Returns the 75th percentile of relative losses, interpolated between neighbors. With five buildings, this is the
/// second worst, so a set has to be good on all but one.
pub(super) fn percentile_75(losses: &[f64]) -> f64 {
    let mut sorted = losses.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = 0.75 * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + place.fract() * (above - below)
}

#[cfg(test)]
mod tests {
    use super::super::tests::plan;
    use super::*;

    #[test]
    fn the_percentile_of_five_buildings_is_the_second_worst() {
        assert_eq!(percentile_75(&[2.0, 1.0, 0.5, 0.5, 0.4]), 1.0);
        assert_eq!(percentile_75(&[1.0, 3.0]), 2.5);
        assert_eq!(percentile_75(&[0.7]), 0.7);
    }

    #[test]
    fn travel_is_limited_on_the_worst_building_unless_the_defaults_travel_more() {
        let outcomes = |travel: [f64; 2]| {
            travel.map(|daily_travel| CellOutcome { daily_travel, ..CellOutcome::default() })
        };
        let defaults = outcomes([1.0, 8.0]);
        let worst = |travel| worst_travel(Limits::UNITARY, &defaults, &outcomes(travel));
        assert_eq!([worst([5.0, 8.0]), worst([4.0, 4.0]), worst([10.0, 0.0])], [1.0, 0.8, 2.0]);
        assert!(worst([0.0, 8.1]) > 1.0 && worst([5.1, 0.0]) > 1.0);
        assert!(worst_travel(Limits::AIR_LOOP_SEARCH, &defaults, &outcomes([4.1, 0.0])) > 1.0);
    }

    #[test]
    fn a_loss_below_sensor_resolution_is_within_the_limits() {
        let cells = |losses: [f64; 2]| {
            losses.map(|temperature_penalty| CellOutcome {
                temperature_penalty,
                steps: 1,
                ..CellOutcome::default()
            })
        };
        let defaults = cells([0.003, 1.0]);
        let worst = |losses| worst_loss(Limits::UNITARY, &plan(0), &defaults, &cells(losses));
        assert!(worst([0.006, 1.1]) < 1.0 && worst([0.006, 1.2]) > 1.0 && worst([0.03, 1.0]) > 1.0);
    }
}
