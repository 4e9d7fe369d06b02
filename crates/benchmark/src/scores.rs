//! The normalised score.

/// The score of a return: itself over the return of the reactive controllers for the same building, task and days
/// (the paper's `compute_normalized_score`). Both are sums of penalties and so negative: lower is better, and below 1
/// beats the baseline.
///
/// | baseline | return | score |
/// |---|---|---|
/// | negative | any | return / baseline; negative for a return above 0, which takes prices below 0 |
/// | 0 | 0 | 1: as good as the baseline |
/// | 0 | negative | ∞ |
/// | 0 | positive | -∞ |
/// | positive | any | none: a ratio would order returns the wrong way round |
///
/// A baseline of 0 takes comfort with a deadband that the reactive controllers never leave, and no weight on energy. There
/// is no score where either is not a number.
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
    fn where_there_is_no_ratio_the_score_still_orders_or_is_none() {
        assert_eq!(normalized_score(0.0, 0.0), Some(1.0));
        assert_eq!(normalized_score(-0.0, 0.0), Some(1.0));
        assert_eq!(normalized_score(-1.0, -0.0), Some(f64::INFINITY));
        assert_eq!(normalized_score(1.0, 0.0), Some(f64::NEG_INFINITY));
        assert_eq!(normalized_score(-1.0, 5.0), None);
        assert_eq!(normalized_score(f64::NAN, -1.0), None);
        assert_eq!(normalized_score(-1.0, f64::NAN), None);
    }
}
