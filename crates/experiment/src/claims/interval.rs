//! Quantities over buildings with their intervals.

use std::collections::BTreeSet;

use b2b_evaluate::statistics::{Interval, Sample, mean, over_buildings, over_pairs};

/// Number of buildings from which an interval is a bootstrap's: of fewer, it would cover less than its 95 %.
const ENOUGH: usize = 5;

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
    /// Returns a quantity with its interval or, of few buildings, with the range of all values.
    fn of(samples: &[Sample<'_>], interval: Interval) -> Self {
        let buildings = samples.iter().map(|each| each.building).collect::<BTreeSet<_>>().len();
        let is_range = buildings < ENOUGH;
        let scores = || samples.iter().map(|each| each.score);
        let (low, high) = match is_range {
            true => (scores().fold(f64::INFINITY, f64::min), scores().fold(f64::NEG_INFINITY, f64::max)),
            false => (interval.low, interval.high),
        };
        Self { interval: Interval { low, high, ..interval }, buildings, is_range }
    }

    /// Returns the quantity whose logarithm this is.
    pub(super) fn exp(self) -> Self {
        let Interval { value, low, high } = self.interval;
        Self { interval: Interval { value: value.exp(), low: low.exp(), high: high.exp() }, ..self }
    }
}

/// Returns a statistic of the buildings' means, sorted, with its interval; `None` without a value.
pub(super) fn measured(samples: &[Sample<'_>], statistic: fn(&[f64]) -> f64) -> Option<Measured> {
    Some(Measured::of(samples, over_buildings(samples, statistic)?))
}

/// Returns a statistic of the buildings' values, for each seed alone, with the means of its values and of the ends of its
/// intervals over seeds: a statistic of tails, which means over seeds do not have.
pub(super) fn by_seed(samples: &[Sample<'_>], statistic: fn(&[f64]) -> f64) -> Option<Measured> {
    let seeds: BTreeSet<_> = samples.iter().map(|each| each.seed).collect();
    let of_seed = |seed| {
        let own: Vec<Sample<'_>> = samples.iter().filter(|each| each.seed == seed).copied().collect();
        measured(&own, statistic)
    };
    let all = seeds.into_iter().map(of_seed).collect::<Option<Vec<Measured>>>()?;
    let of =
        |end: fn(&Interval) -> f64| mean(&all.iter().map(|each| end(&each.interval)).collect::<Vec<_>>());
    Some(Measured {
        interval: Interval {
            value: of(|each| each.value),
            low: of(|each| each.low),
            high: of(|each| each.high),
        },
        buildings: all.iter().map(|each| each.buildings).max()?,
        is_range: all.iter().any(|each| each.is_range),
    })
}

/// Returns a statistic of the differences between two agents' means in the buildings of both, likewise.
pub(super) fn difference(
    samples: &[Sample<'_>],
    others: &[Sample<'_>],
    statistic: fn(&[f64]) -> f64,
) -> Option<Measured> {
    let differences = samples.iter().filter_map(|each| {
        let same = others.iter().filter(|other| other.building == each.building);
        let same: Vec<f64> = same.map(|other| other.score).collect();
        (!same.is_empty()).then(|| Sample { score: each.score - mean(&same), ..*each })
    });
    let differences: Vec<Sample<'_>> = differences.collect();
    Some(Measured::of(&differences, over_pairs(samples, others, statistic)?))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use b2b_evaluate::statistics::median;

    /// Returns the samples of buildings, each with its values.
    pub(in crate::claims) fn buildings(values: &[Vec<f64>]) -> Vec<Sample<'static>> {
        let of = |(number, own): (usize, &Vec<f64>)| {
            let building: &str = number.to_string().leak();
            let sample = move |(seed, score)| Sample {
                building_type: "",
                building,
                case: [""; 2],
                agent: "",
                seed,
                score,
            };
            (0..).zip(own.clone()).map(sample)
        };
        values.iter().enumerate().flat_map(of).collect()
    }

    #[test]
    fn buildings_are_resampled_and_two_have_their_range() {
        let many: Vec<Vec<f64>> = (0..100).map(|index| vec![f64::from(index)]).collect();
        let Measured { interval, buildings: count, is_range } = measured(&buildings(&many), mean).unwrap();
        // The standard error of the mean of a uniform sample is 100 / √12 / √100.
        let error = 100.0 / 12.0_f64.sqrt() / 10.0;
        assert!((interval.high - interval.value - 1.96 * error).abs() < 0.6, "{interval:?}");
        assert_eq!((interval.value, count, is_range), (49.5, 100, false));
        let two = measured(&buildings(&[vec![1.0, 3.0], vec![4.0]]), median).unwrap();
        assert_eq!((two.interval.value, two.interval.low, two.interval.high), (3.0, 1.0, 4.0));
        assert!(two.is_range && measured(&[], median).is_none());
        let one = measured(&buildings(&[vec![0.0]]), median).unwrap().exp();
        assert_eq!((one.interval.low, one.interval.high), (1.0, 1.0));
    }

    #[test]
    fn agents_are_compared_in_the_buildings_of_both() {
        let own = buildings(&[vec![1.0, 3.0], vec![2.0, 4.0], vec![9.0, 11.0], vec![50.0, 50.0]]);
        let others = buildings(&[vec![4.0], vec![5.0], vec![12.0]]);
        let Measured { interval, buildings, is_range } = difference(&own, &others, median).unwrap();
        assert_eq!((interval.value, buildings, is_range), (-2.0, 3, true));
        assert_eq!((interval.low, interval.high), (-3.0, -1.0));
    }

    #[test]
    fn the_tail_of_each_seed_counts() {
        // Another house fails with each seed.
        let failed = |house: u64, seed: u64| if house % 5 == seed { 9.0 } else { 1.0 };
        let houses: Vec<Vec<f64>> =
            (0..20).map(|house| (0..5).map(|seed| failed(house, seed)).collect()).collect();
        let worst = |sorted: &[f64]| *sorted.last().unwrap();
        assert_eq!(by_seed(&buildings(&houses), worst).unwrap().interval.value, 9.0);
        assert_eq!(measured(&buildings(&houses), worst).unwrap().interval.value, 2.6);
        assert!(by_seed(&[], worst).is_none());
    }
}
