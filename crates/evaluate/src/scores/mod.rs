//! The scores of an episode: the paper's normalized score, the resolved score, and the score at comfort of the tasks of
//! operation.

mod at_comfort;

use b2b_env::EpisodeMetrics;

pub use at_comfort::{DISCOMFORT_COST, FREE_DISCOMFORT, Operated, excess_discomfort, score_at_comfort};

/// Returns the normalized score of an episode: its return divided by the reactive controllers' return for the same
/// building, task and days (the paper's `compute_normalized_score`). Returns are negated sums of penalties: a lower
/// score is better; the baseline scores 1.
///
/// | baseline | return | score |
/// |---|---|---|
/// | negative | any | return / baseline; negative for a return above 0, which requires negative prices |
/// | 0 | 0 | 1: as good as the baseline |
/// | 0 | negative | ∞ |
/// | 0 | positive | -∞ |
/// | positive | any | none: a ratio would reverse the order of returns |
///
/// A baseline of 0 requires a comfort deadband that the reactive controllers never leave, and no weight on energy.
/// There is no score if either return is not a number.
pub fn normalized_score(episode_return: f64, baseline: f64) -> Option<f64> {
    if baseline.is_nan() || baseline > 0.0 || episode_return.is_nan() {
        return None;
    }
    if baseline < 0.0 {
        return Some(episode_return / baseline);
    }
    Some(if episode_return == 0.0 { 1.0 } else { f64::INFINITY * -episode_return.signum() })
}

/// Smallest deviation that a score resolves, K: the accuracy that ISO 7726:1998 (table 2, class C, comfort) calls
/// desirable for an air temperature sensor; 0.5 K is required.
pub const RESOLUTION: f64 = 0.2;

/// The baseline of an episode: its [controller](crate::BuiltIn::baseline_of) in the same building, task and days.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    /// Its return.
    pub episode_return: f64,
    /// Its HVAC energy, Wh/m².
    pub energy: f64,
    /// Its amount of the task's resource, in the unit of the resource, if it is known.
    pub resource: Option<f64>,
    /// Its discomfort in an operation task, K·h per zone.
    pub discomfort: Option<f64>,
}

/// The score of an episode, and the resolved score, which ignores deviations too small for a thermometer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scores {
    /// [`normalized_score`], or [`score_at_comfort`] in an operation task.
    pub score: Option<f64>,
    /// [`resolved_score`], or [`score_at_comfort`] in an operation task.
    pub resolved: Option<f64>,
}

impl Baseline {
    /// Returns the scores of an episode from its metrics and `resource`, the amount of the task's resource.
    pub fn scores(&self, metrics: &EpisodeMetrics, resource: Option<f64>, steps_per_hour: u32) -> Scores {
        let EpisodeMetrics { episode_return, steps, tdis_tot, .. } = *metrics;
        match tdis_tot {
            None => Scores {
                score: normalized_score(episode_return, self.episode_return),
                resolved: resolved_score(episode_return, self.episode_return, steps),
            },
            Some(discomfort) => {
                let days = steps as f64 / (24.0 * f64::from(steps_per_hour));
                let own = resource.map(|used| Operated { used, discomfort });
                let score = own.and_then(|own| score_at_comfort(own, self.operated()?, days));
                Scores { score, resolved: score }
            }
        }
    }

    fn operated(&self) -> Option<Operated> {
        Some(Operated { used: self.resource?, discomfort: self.discomfort? })
    }
}

/// Returns the resolved score of an episode: (P + n r²) / (P₀ + n r²), where P is its penalty (the negated return, with
/// the energy penalty if the task has one), P₀ is the reactive controllers' penalty, n the number of steps and r = 0.2
/// K ([`RESOLUTION`]). It treats every zone as if it deviated by another 0.2 K, independently: differences that a
/// thermometer could not resolve hardly affect the score. Lower is better; it is below 1 exactly where
/// the normalized score is.
///
/// There is no score if the denominator is not above 0, which requires negative prices, or if either return is not a
/// number.
pub fn resolved_score(episode_return: f64, baseline: f64, steps: usize) -> Option<f64> {
    let floor = steps as f64 * RESOLUTION * RESOLUTION;
    let (penalty, baseline) = (floor - episode_return, floor - baseline);
    (baseline > 0.0 && !penalty.is_nan()).then(|| penalty / baseline)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_penalty_is_half_the_score() {
        assert_eq!(normalized_score(-50.0, -100.0), Some(0.5));
        assert_eq!(normalized_score(-100.0, -100.0), Some(1.0));
        assert_eq!(normalized_score(10.0, -100.0), Some(-0.1));
    }

    #[test]
    fn without_a_ratio_the_score_still_orders_policies_or_is_none() {
        assert_eq!(normalized_score(0.0, 0.0), Some(1.0));
        assert_eq!(normalized_score(-0.0, 0.0), Some(1.0));
        assert_eq!(normalized_score(-1.0, -0.0), Some(f64::INFINITY));
        assert_eq!(normalized_score(1.0, 0.0), Some(f64::NEG_INFINITY));
        assert_eq!(normalized_score(-1.0, 5.0), None);
        assert_eq!(normalized_score(f64::NAN, -1.0), None);
        assert_eq!(normalized_score(-1.0, f64::NAN), None);
    }

    #[test]
    fn the_resolved_score_does_not_tell_deviations_apart_that_no_thermometer_could() {
        let of = |deviation: f64| -1000.0 * deviation * deviation;
        let [normalized, resolved] =
            [normalized_score(of(0.1), of(0.03)).unwrap(), resolved_score(of(0.1), of(0.03), 1000).unwrap()];
        assert!((normalized - 11.1).abs() < 0.1, "{normalized}");
        assert!((resolved - 1.22).abs() < 0.01, "{resolved}");
        // Both agree for large deviations.
        let [normalized, resolved] =
            [normalized_score(of(2.0), of(4.0)).unwrap(), resolved_score(of(2.0), of(4.0), 1000).unwrap()];
        assert!((normalized - resolved).abs() < 0.01, "{normalized} {resolved}");
        assert_eq!(resolved_score(of(0.03), of(0.03), 1000), Some(1.0));
        assert_eq!(resolved_score(0.0, 0.0, 10), Some(1.0));
        assert_eq!(resolved_score(-1.0, 5.0, 10), None);
        assert_eq!(resolved_score(f64::NAN, -1.0, 10), None);
    }
}
