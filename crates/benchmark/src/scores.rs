//! The normalized score.

/// Returns the normalized score of an episode: its return divided by that of the reactive controllers for the same
/// building, task and days (the paper's `compute_normalized_score`). Returns are negated sums of penalties: a lower score
/// is better, and below 1 beats the baseline.
///
/// | baseline | return | score |
/// |---|---|---|
/// | negative | any | return / baseline; negative for a return above 0, which requires negative prices |
/// | 0 | 0 | 1: as good as the baseline |
/// | 0 | negative | ∞ |
/// | 0 | positive | -∞ |
/// | positive | any | none: a ratio would order returns the wrong way round |
///
/// A baseline of 0 requires a comfort deadband that the reactive controllers never leave, and no weight on energy. There
/// is no score if either return is not a number.
pub fn normalized_score(episode_return: f64, baseline: f64) -> Option<f64> {
    let defined = baseline <= 0.0 && !episode_return.is_nan();
    defined.then(|| match () {
        () if baseline < 0.0 => episode_return / baseline,
        () if episode_return == 0.0 => 1.0,
        () if episode_return < 0.0 => f64::INFINITY,
        () => f64::NEG_INFINITY,
    })
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
}
