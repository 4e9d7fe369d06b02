//! Quantities over buildings with their intervals.

use b2b_evaluate::statistics::{CONFIDENCE, DRAWS, Interval, mean, quantile};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Minimum number of buildings for a bootstrap.
const FEWEST: usize = 3;

/// A quantity over buildings.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    pub(super) interval: Interval,
    /// Number of buildings.
    pub(super) buildings: usize,
    /// Whether the interval is the range of all values, because there are too few buildings for a bootstrap.
    pub(super) is_range: bool,
}

impl Measured {
    /// Returns the quantity whose logarithm this is.
    pub(super) fn exp(self) -> Self {
        let Interval { value, low, high } = self.interval;
        Self { interval: Interval { value: value.exp(), low: low.exp(), high: high.exp() }, ..self }
    }
}

/// Returns a statistic of the buildings' means, sorted, with a bootstrap interval over buildings; `None` without a
/// value.
pub(super) fn measured(buildings: &[Vec<f64>], statistic: fn(&[f64]) -> f64) -> Option<Measured> {
    let mut means: Vec<f64> = buildings.iter().filter(|own| !own.is_empty()).map(|own| mean(own)).collect();
    if means.is_empty() {
        return None;
    }
    means.sort_by(f64::total_cmp);
    let (value, count) = (statistic(&means), means.len());
    let is_range = count < FEWEST;
    let (low, high) = if is_range { range(buildings) } else { bootstrap(&means, statistic) };
    Some(Measured { interval: Interval { value, low, high }, buildings: count, is_range })
}

fn range(buildings: &[Vec<f64>]) -> (f64, f64) {
    let all = buildings.iter().flatten().copied();
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

fn bootstrap(values: &[f64], statistic: fn(&[f64]) -> f64) -> (f64, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut drawn: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let mut resampled: Vec<f64> =
                values.iter().map(|_| values[random.random_range(0..values.len())]).collect();
            resampled.sort_by(f64::total_cmp);
            statistic(&resampled)
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let tail = (1.0 - CONFIDENCE) / 2.0;
    (quantile(&drawn, tail), quantile(&drawn, 1.0 - tail))
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_evaluate::statistics::median;

    #[test]
    fn buildings_are_resampled_and_two_have_their_range() {
        let many: Vec<Vec<f64>> = (0..100).map(|index| vec![f64::from(index)]).collect();
        let Measured { interval, buildings, is_range } = measured(&many, mean).unwrap();
        // The standard error of the mean of a uniform sample is 100 / √12 / √100.
        let error = 100.0 / 12.0_f64.sqrt() / 10.0;
        assert!((interval.high - interval.value - 1.96 * error).abs() < 0.6, "{interval:?}");
        assert_eq!((interval.value, buildings, is_range), (49.5, 100, false));
        let two = measured(&[vec![1.0, 3.0], vec![4.0]], median).unwrap();
        assert_eq!((two.interval.value, two.interval.low, two.interval.high), (3.0, 1.0, 4.0));
        assert!(two.is_range && measured(&[vec![]], median).is_none());
        let one = measured(&[vec![0.0]], median).unwrap().exp();
        assert_eq!((one.interval.low, one.interval.high), (1.0, 1.0));
    }
}
