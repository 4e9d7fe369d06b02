//! The score of the operation tasks: cost relative to the baseline, at comfort.

use b2b_env::OPERATION_WEIGHT;

/// Free allowance of discomfort beyond the baseline's, K·h per zone and day: half an hour at the accuracy of an air
/// temperature sensor, [`RESOLUTION`](super::RESOLUTION).
pub const FREE_DISCOMFORT: f64 = 0.1;

/// Cost of a K·h per zone beyond the allowance, in days of the baseline's cost: half a day. The reward of these tasks
/// weighs discomfort in the same way.
pub const DISCOMFORT_COST: f64 = OPERATION_WEIGHT / 24.0;

/// The resource use and discomfort of an episode of operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operated {
    /// Amount of the task's resource: cost, unless the task says otherwise.
    pub used: f64,
    /// Deviation outside the band integrated over time, K·h per zone.
    pub discomfort: f64,
}

/// Returns the discomfort of an episode of `days` days beyond the baseline's and the free allowance, K·h per zone.
pub fn excess_discomfort(discomfort: f64, baseline: f64, days: f64) -> f64 {
    (discomfort - baseline - FREE_DISCOMFORT * days).max(0.0)
}

/// Returns the score at comfort of an episode of `days` days: its cost divided by the baseline's, plus
/// [`DISCOMFORT_COST`] days of the baseline's cost for every K·h of [`excess_discomfort`], as a share of the episode.
/// Lower is better; the baseline scores 1. Comfort beyond the baseline's gains nothing.
///
/// | cost of the baseline | own cost | ratio |
/// |---|---|---|
/// | positive | any | own / baseline |
/// | 0 | 0 | 1: as good as the baseline |
/// | 0 | positive | ∞ |
/// | 0 | negative | none |
/// | negative | any | none: it would reverse the order of costs |
pub fn score_at_comfort(own: Operated, baseline: Operated, days: f64) -> Option<f64> {
    let ratio = match baseline.used {
        used if used > 0.0 => own.used / used,
        0.0 if own.used == 0.0 => 1.0,
        0.0 if own.used > 0.0 => f64::INFINITY,
        _ => return None,
    };
    let excess = excess_discomfort(own.discomfort, baseline.discomfort, days);
    Some(ratio + DISCOMFORT_COST * excess / days).filter(|score| !score.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASELINE: Operated = Operated { used: 2.0, discomfort: 5.0 };

    fn score(used: f64, discomfort: f64) -> Option<f64> {
        score_at_comfort(Operated { used, discomfort }, BASELINE, 14.0)
    }

    #[test]
    fn at_the_baseline_s_comfort_the_score_is_the_ratio_of_costs() {
        assert_eq!(score(2.0, 5.0), Some(1.0));
        assert_eq!(score(1.5, 5.0), Some(0.75));
        assert_eq!(score(1.5, 0.0), Some(0.75), "polishing gains nothing");
        assert_eq!(score(1.5, 6.4), Some(0.75), "a tenth of a K·h a day is free");
    }

    #[test]
    fn a_kelvin_hour_beyond_costs_half_a_day() {
        let [free, beyond] = [6.4, 7.4].map(|discomfort| score(1.5, discomfort).unwrap());
        assert!((beyond - free - 0.5 / 14.0).abs() < 1e-12);
        // Everything off at 30 K·h a day.
        assert!(score(0.0, 420.0).unwrap() > 14.0);
    }

    #[test]
    fn without_a_ratio_the_score_still_orders_policies_or_is_none() {
        let free = Operated { used: 0.0, discomfort: 0.0 };
        let of = |used| score_at_comfort(Operated { used, discomfort: 0.0 }, free, 14.0);
        assert_eq!([of(0.0), of(0.1), of(-0.1)], [Some(1.0), Some(f64::INFINITY), None]);
        let earned = Operated { used: -1.0, discomfort: 0.0 };
        assert_eq!(score_at_comfort(free, earned, 14.0), None);
        assert_eq!(score(f64::NAN, 5.0), None);
    }
}
