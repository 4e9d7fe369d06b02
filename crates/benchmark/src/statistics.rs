//! Aggregates of scores with confidence intervals, after the recommendations of Agarwal, Schwarzer, Castro, Courville and
//! Bellemare, "Deep Reinforcement Learning at the Edge of the Statistical Precipice", NeurIPS 2021 (rliable): the
//! interquartile mean beside median and mean, and percentile intervals of a stratified bootstrap.
//!
//! A stratum here is a building type: buildings are drawn anew within their type, so that the mix of types stays.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// Draws of the bootstrap.
pub const DRAWS: usize = 5000;
/// Share that an interval covers.
pub const CONFIDENCE: f64 = 0.95;

/// A value and the interval that a bootstrap gives it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Of the scores themselves.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Scores in a few numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Aggregate {
    /// How many scores.
    pub episodes: usize,
    /// Arithmetic mean.
    pub mean: Interval,
    /// The value in the middle; of an even number, the mean of the two.
    pub median: Interval,
    /// Mean of what is left without the lowest and the highest quarter.
    pub interquartile_mean: Interval,
    /// Share of scores below 1.
    pub beats_baseline: Interval,
}

/// Aggregates scores, one list for each stratum. `None` without any. The same seed gives the same intervals.
pub fn aggregate(strata: &[Vec<f64>], seed: u64) -> Option<Aggregate> {
    let episodes: usize = strata.iter().map(Vec::len).sum();
    if episodes == 0 {
        return None;
    }
    let measures: [fn(&[f64]) -> f64; 4] = [mean, median, interquartile_mean, share_below_one];
    let measure = |scores: &[f64]| measures.map(|measure| measure(scores));
    let mut scores: Vec<f64> = strata.concat();
    scores.sort_by(f64::total_cmp);
    let values = measure(&scores);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn: [Vec<f64>; 4] = Default::default();
    for _ in 0..DRAWS {
        scores.clear();
        for stratum in strata.iter().filter(|stratum| !stratum.is_empty()) {
            scores.extend((0..stratum.len()).map(|_| stratum[random.random_range(0..stratum.len())]));
        }
        scores.sort_by(f64::total_cmp);
        for (drawn, value) in drawn.iter_mut().zip(measure(&scores)) {
            drawn.push(value);
        }
    }
    let mut intervals = drawn.into_iter().zip(values).map(|(mut drawn, value)| {
        drawn.sort_by(f64::total_cmp);
        let tail = (1.0 - CONFIDENCE) / 2.0;
        Interval { value, low: quantile(&drawn, tail), high: quantile(&drawn, 1.0 - tail) }
    });
    let mut next = || intervals.next();
    Some(Aggregate {
        episodes,
        mean: next()?,
        median: next()?,
        interquartile_mean: next()?,
        beats_baseline: next()?,
    })
}

fn mean(sorted: &[f64]) -> f64 {
    sorted.iter().sum::<f64>() / sorted.len() as f64
}

/// Median of sorted numbers.
pub fn median(sorted: &[f64]) -> f64 {
    quantile(sorted, 0.5)
}

/// Mean of sorted numbers without a quarter, rounded down, at either end (`scipy.stats.trim_mean` at 0.25, as rliable
/// has it).
pub fn interquartile_mean(sorted: &[f64]) -> f64 {
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

fn share_below_one(sorted: &[f64]) -> f64 {
    sorted.iter().filter(|score| **score < 1.0).count() as f64 / sorted.len() as f64
}

/// A quantile of sorted numbers, between two of them in proportion (numpy's default).
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    // Infinite scores have no difference.
    if below == above { below } else { below + (above - below) * place.fract() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked out by hand from the definitions of `np.median`, `scipy.stats.trim_mean(x, 0.25)` and `np.percentile`.
    #[test]
    fn the_measures_follow_the_definitions_of_numpy_and_scipy() {
        let mut scores = vec![0.91, 1.2, 0.73, 1.05, 0.99, 3.4, 0.88, 1.01, 0.97, 1.6];
        scores.sort_by(f64::total_cmp);
        assert!((mean(&scores) - 1.274).abs() < 1e-12);
        assert!((median(&scores) - 1.0).abs() < 1e-12);
        // Without the two lowest and the two highest: 0.91, 0.97, 0.99, 1.01, 1.05, 1.2.
        assert!((interquartile_mean(&scores) - 6.13 / 6.0).abs() < 1e-12);
        assert!((quantile(&scores, 0.1) - 0.865).abs() < 1e-12);
        assert_eq!(share_below_one(&scores), 0.5);
    }

    #[test]
    fn an_interval_holds_its_value_and_comes_out_the_same_again() {
        let strata = [vec![0.9, 1.1, 1.0, 1.3], vec![2.0, 2.2, 2.1], vec![]];
        let first = aggregate(&strata, 7).unwrap();
        assert_eq!(aggregate(&strata, 7), Some(first.clone()));
        assert_eq!(first.episodes, 7);
        for each in [first.mean, first.median, first.interquartile_mean] {
            assert!(each.low <= each.value && each.value <= each.high && each.low < each.high, "{each:?}");
        }
        assert_eq!(aggregate(&[vec![]], 0), None);
    }

    #[test]
    fn the_mix_of_strata_stays() {
        // Each stratum is constant: whatever is drawn, the mean is the same.
        let steady = aggregate(&[vec![1.0; 5], vec![3.0; 5]], 0).unwrap();
        assert_eq!((steady.mean.low, steady.mean.high), (2.0, 2.0));
        let mixed = aggregate(&[[vec![1.0; 5], vec![3.0; 5]].concat()], 0).unwrap();
        assert!(mixed.mean.low < 1.7 && mixed.mean.high > 2.3, "{mixed:?}");
    }

    #[test]
    fn a_score_without_bound_is_no_nonsense() {
        let aggregate = aggregate(&[vec![0.5, 0.6, f64::INFINITY, 0.7]], 0).unwrap();
        assert_eq!(aggregate.mean.value, f64::INFINITY);
        assert!((aggregate.interquartile_mean.value - 0.65).abs() < 1e-12);
        assert!(!aggregate.mean.low.is_nan() && !aggregate.median.high.is_nan(), "{aggregate:?}");
    }
}
