//! Outcomes of a set of parameters on the buildings of a plan, and the score over them.

use b2b_env::Metrics;
use serde::{Deserialize, Serialize};

use crate::Measured;

/// Sums over the episodes of a building.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Return, summed over the episodes.
    pub episode_return: f64,
    /// Steps.
    pub steps: usize,
    /// HVAC energy, Wh/m².
    pub energy: f64,
    /// Actuator travel, full strokes/day, averaged over actuators and episodes.
    pub daily_travel: f64,
}

/// Actuator travel above which actuators hunt, full strokes/day, unless it is higher under the defaults. A target that
/// jumps up and down once a day moves an actuator there and back twice: four strokes.
const MAX_TRAVEL: f64 = 5.0;

impl Outcome {
    /// Sums up the metrics of some episodes.
    pub fn of(episodes: &[Metrics]) -> Self {
        let share = 1.0 / episodes.len().max(1) as f64;
        episodes.iter().fold(Self::default(), |sum, metrics| Self {
            episode_return: sum.episode_return + metrics.episode_return,
            steps: sum.steps + metrics.steps,
            energy: sum.energy + metrics.electricity + metrics.gas,
            daily_travel: sum.daily_travel + share * metrics.daily_travel(),
        })
    }

    /// The return, penalized by actuator travel: twice as bad where actuators begin to hunt.
    fn penalized_return(&self) -> f64 {
        self.episode_return * (1.0 + (self.daily_travel / MAX_TRAVEL).powi(2))
    }
}

/// Compares outcomes with those of the default parameters.
pub fn measured(defaults: &[Outcome], outcomes: &[Outcome]) -> Measured {
    Measured {
        default_score: score(defaults, defaults),
        score: score(defaults, outcomes),
        default_penalty: mean_penalty(defaults),
        penalty: mean_penalty(outcomes),
        default_daily_travel: mean_travel(defaults),
        daily_travel: mean_travel(outcomes),
        energy: mean_energy(outcomes),
    }
}

/// Returns the 25th percentile over the buildings of the return relative to the loss of the defaults: −1 is as good as
/// the defaults, 0 is perfect.
pub(super) fn score(defaults: &[Outcome], outcomes: &[Outcome]) -> f64 {
    percentile_of(|outcome| outcome.episode_return, defaults, outcomes)
}

/// Returns the score that the search maximizes: that of the returns penalized by actuator travel.
pub(super) fn search_score(defaults: &[Outcome], outcomes: &[Outcome]) -> f64 {
    percentile_of(Outcome::penalized_return, defaults, outcomes)
}

fn percentile_of(value: fn(&Outcome) -> f64, defaults: &[Outcome], outcomes: &[Outcome]) -> f64 {
    let relative = |(outcome, default): (&Outcome, &Outcome)| {
        value(outcome) / value(default).abs().max(f64::MIN_POSITIVE)
    };
    percentile_25(outcomes.iter().zip(defaults).map(relative).collect())
}

/// Whether the actuators of no building hunt. A mean over buildings would hide one that does.
pub(super) fn is_calm(defaults: &[Outcome], outcomes: &[Outcome]) -> bool {
    let calm = |(outcome, default): (&Outcome, &Outcome)| {
        outcome.daily_travel <= default.daily_travel.max(MAX_TRAVEL)
    };
    outcomes.iter().zip(defaults).all(calm)
}

/// Returns the 25th percentile, interpolated between neighbors.
fn percentile_25(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = 0.25 * (values.len() - 1) as f64;
    let (below, above) = (values[place.floor() as usize], values[place.ceil() as usize]);
    below + place.fract() * (above - below)
}

/// Mean penalty per step, averaged over the buildings.
fn mean_penalty(outcomes: &[Outcome]) -> f64 {
    mean_per_step(outcomes, |outcome| -outcome.episode_return)
}

/// Mean energy per step, averaged over the buildings, Wh/m².
fn mean_energy(outcomes: &[Outcome]) -> f64 {
    mean_per_step(outcomes, |outcome| outcome.energy)
}

/// Actuator travel, averaged over the buildings, full strokes/day.
fn mean_travel(outcomes: &[Outcome]) -> f64 {
    outcomes.iter().map(|outcome| outcome.daily_travel).sum::<f64>() / outcomes.len() as f64
}

fn mean_per_step(outcomes: &[Outcome], sum: impl Fn(&Outcome) -> f64) -> f64 {
    outcomes.iter().map(|outcome| sum(outcome) / outcome.steps.max(1) as f64).sum::<f64>()
        / outcomes.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_score_is_a_percentile_over_equally_weighted_buildings() {
        let outcomes = |returns: [f64; 5]| {
            returns.map(|episode_return| Outcome { episode_return, ..Outcome::default() })
        };
        let defaults = outcomes([-1.0, -10.0, -100.0, -1.0, -2.0]);
        assert_eq!(score(&defaults, &defaults), -1.0);
        // Relative: -2, -1, -0.5, -0.5, -0.5.
        assert_eq!(score(&defaults, &outcomes([-2.0, -10.0, -50.0, -0.5, -1.0])), -1.0);
        assert_eq!(percentile_25(vec![-3.0, -1.0]), -2.5);
    }
}
