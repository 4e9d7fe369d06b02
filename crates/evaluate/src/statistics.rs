//! Aggregates of scores with confidence intervals, after the recommendations of Agarwal, Schwarzer, Castro, Courville
//! and Bellemare, "Deep Reinforcement Learning at the Edge of the Statistical Precipice", NeurIPS 2021 (rliable): the
//! interquartile mean in addition to median and mean, and percentile intervals of a stratified bootstrap.
//!
//! A stratum here is a building type, in a benchmark under one task and run period: buildings are resampled within
//! their stratum, which preserves the mix of strata.

use std::fmt;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::any_number;

/// Bootstrap resamples.
pub const DRAWS: usize = 5000;
/// Confidence level of the intervals.
pub const CONFIDENCE: f64 = 0.95;
/// Difference of a score from the baseline's, 1, up to which it is no difference.
pub const MARGIN: f64 = 0.01;

/// A value with its bootstrap confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Value over the scores themselves.
    #[serde(with = "any_number")]
    pub value: f64,
    /// Lower end.
    #[serde(with = "any_number")]
    pub low: f64,
    /// Upper end.
    #[serde(with = "any_number")]
    pub high: f64,
}

/// How a policy compares with the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The score is better by more than [`MARGIN`], and all of its interval is below 1.
    Beats,
    /// Neither.
    NoDifference,
    /// The score is worse by more than [`MARGIN`], and all of its interval is above 1.
    Worse,
}

impl Verdict {
    /// Returns the verdict on a score with its interval.
    pub fn of(score: Interval) -> Self {
        let Interval { value, low, high } = score;
        match () {
            () if value < 1.0 - MARGIN && high < 1.0 => Self::Beats,
            () if value > 1.0 + MARGIN && low > 1.0 => Self::Worse,
            () => Self::NoDifference,
        }
    }

    /// Returns the verdict on a single score.
    pub fn of_one(score: f64) -> Self {
        Self::of(Interval { value: score, low: score, high: score })
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Beats => "beats",
            Self::NoDifference => "no difference",
            Self::Worse => "worse",
        })
    }
}

/// Aggregated scores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aggregate {
    /// Number of scores, or of buildings under a task in a run period if the scores of seeds are averaged.
    pub episodes: usize,
    /// Arithmetic mean.
    pub mean: Interval,
    /// Median.
    pub median: Interval,
    /// Interquartile mean: mean without the lowest and the highest quarter.
    pub interquartile_mean: Interval,
    /// Lowest score.
    #[serde(with = "any_number")]
    pub min: f64,
    /// Highest score.
    #[serde(with = "any_number")]
    pub max: f64,
    /// Share of scores below 1.
    pub beats_baseline: Interval,
    /// Number of scores below 1.
    pub beats_baseline_count: usize,
}

impl Aggregate {
    /// Returns the share of scores below 1, in percent.
    pub fn beats_baseline_percent(&self) -> f64 {
        100.0 * self.beats_baseline.value
    }

    /// Returns the percentage with the number of scores: `75 (6 of 8)`.
    pub fn beats_baseline_text(&self) -> String {
        let Self { beats_baseline_count, episodes, .. } = self;
        format!("{:.0} ({beats_baseline_count} of {episodes})", self.beats_baseline_percent())
    }
}

/// Returns a score as tables show it: with three decimals near the baseline, fewer from 10 on.
pub fn score_text(score: f64) -> String {
    let decimals = match score.abs() {
        small if small < 9.9995 => 3,
        medium if medium < 99.95 => 1,
        _ => 0,
    };
    match format!("{score:.decimals$}") {
        zero if zero == "-0.000" => "0.000".to_owned(),
        text => text,
    }
}

/// Writes the value, and the interval in brackets unless its ends are equal.
impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [value, low, high] = [self.value, self.low, self.high].map(score_text);
        if self.low == self.high { f.write_str(&value) } else { write!(f, "{value} [{low}, {high}]") }
    }
}

/// Scores of one building under one task, one per seed.
pub type Cluster = Vec<f64>;

/// A point of a performance profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// A score.
    pub score: f64,
    /// Share of buildings' mean scores over seeds at or below it.
    pub share: Interval,
}

/// Aggregates scores, one list per stratum; `None` without scores. The same seed gives the same intervals.
pub fn aggregate(strata: &[Vec<f64>], seed: u64) -> Option<Aggregate> {
    let alone = |scores: &Vec<f64>| scores.iter().map(|score| vec![*score]).collect();
    aggregate_clusters(&strata.iter().map(alone).collect::<Vec<_>>(), seed)
}

/// Aggregates scores of several seeds: each building counts once, with the mean over its seeds. The bootstrap resamples
/// buildings within their stratum, and seeds within each resampled building.
pub fn aggregate_clusters(strata: &[Vec<Cluster>], seed: u64) -> Option<Aggregate> {
    let measure = |scores: &[f64]| {
        vec![mean(scores), median(scores), interquartile_mean(scores), share_up_to(scores, is_below_baseline)]
    };
    let intervals = bootstrap(&[strata], seed, |lists| measure(lists[0]))?;
    let [mean, median, interquartile_mean, beats_baseline] = intervals[..] else {
        return None;
    };
    let scores: Vec<f64> = strata.iter().flatten().map(|seeds| self::mean(seeds)).collect();
    Some(Aggregate {
        episodes: scores.len(),
        mean,
        median,
        interquartile_mean,
        min: scores.iter().copied().fold(f64::INFINITY, f64::min),
        max: scores.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        beats_baseline,
        beats_baseline_count: scores.iter().filter(|score| is_below_baseline(**score)).count(),
    })
}

/// Returns the performance profile: for each bound the share of buildings with a score at or below it.
pub fn profile(strata: &[Vec<Cluster>], bounds: &[f64], seed: u64) -> Vec<Share> {
    let shares =
        |scores: &[f64]| bounds.iter().map(|bound| share_up_to(scores, |score| score <= *bound)).collect();
    let shares = bootstrap(&[strata], seed, |lists| shares(lists[0])).unwrap_or_default();
    bounds.iter().zip(shares).map(|(score, share)| Share { score: *score, share }).collect()
}

/// Returns the difference between the interquartile means of two sets of scores.
pub fn difference(above: &[Vec<Cluster>], below: &[Vec<Cluster>], seed: u64) -> Option<Interval> {
    let measure = |lists: &[&[f64]]| vec![interquartile_mean(lists[0]) - interquartile_mean(lists[1])];
    bootstrap(&[above, below], seed, measure)?.pop()
}

/// Returns measures of lists of scores with bootstrap intervals; `None` if a list is empty.
fn bootstrap(
    lists: &[&[Vec<Cluster>]],
    seed: u64,
    measure: impl Fn(&[&[f64]]) -> Vec<f64>,
) -> Option<Vec<Interval>> {
    let sorted = |mut scores: Vec<f64>| {
        scores.sort_by(f64::total_cmp);
        scores
    };
    let own = |strata: &&[Vec<Cluster>]| sorted(strata.iter().flatten().map(|seeds| mean(seeds)).collect());
    let mut scores: Vec<Vec<f64>> = lists.iter().map(own).collect();
    if scores.iter().any(Vec::is_empty) {
        return None;
    }
    let of = |scores: &[Vec<f64>]| measure(&scores.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let values = of(&scores);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = vec![Vec::with_capacity(DRAWS); values.len()];
    for _ in 0..DRAWS {
        for (scores, strata) in scores.iter_mut().zip(lists) {
            scores.clear();
            draw(strata, &mut random, scores);
            scores.sort_by(f64::total_cmp);
        }
        for (drawn, value) in drawn.iter_mut().zip(of(&scores)) {
            drawn.push(value);
        }
    }
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let interval = |(drawn, value): (Vec<f64>, f64)| {
        let drawn = sorted(drawn);
        Interval { value, low: quantile(&drawn, tail), high: quantile(&drawn, 1.0 - tail) }
    };
    Some(drawn.into_iter().zip(values).map(interval).collect())
}

/// Resamples the clusters of each stratum with replacement; each counts with the mean of its resampled scores.
fn draw(strata: &[Vec<Cluster>], random: &mut ChaCha8Rng, scores: &mut Vec<f64>) {
    for stratum in strata.iter().filter(|stratum| !stratum.is_empty()) {
        for _ in 0..stratum.len() {
            let seeds = &stratum[random.random_range(0..stratum.len())];
            scores.push(match seeds[..] {
                [only] => only,
                _ => {
                    let sum: f64 = (0..seeds.len()).map(|_| seeds[random.random_range(0..seeds.len())]).sum();
                    sum / seeds.len() as f64
                }
            });
        }
    }
}

/// Returns the mean of at least one number.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Returns the median of sorted numbers.
pub fn median(sorted: &[f64]) -> f64 {
    quantile(sorted, 0.5)
}

/// Returns the mean of sorted numbers without a quarter, rounded down, at either end (`scipy.stats.trim_mean` at 0.25,
/// as in rliable).
pub fn interquartile_mean(sorted: &[f64]) -> f64 {
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

/// Returns whether a score is below 1. The baseline's own score may differ from 1 by rounding.
pub fn is_below_baseline(score: f64) -> bool {
    score < 1.0 - 1e-6
}

fn share_up_to(scores: &[f64], counts: impl Fn(f64) -> bool) -> f64 {
    scores.iter().filter(|score| counts(**score)).count() as f64 / scores.len() as f64
}

/// Returns a quantile of sorted numbers with linear interpolation (numpy's default).
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    // The difference of infinite scores is not a number.
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
        assert_eq!(share_up_to(&scores, is_below_baseline), 0.5);
        assert!(!is_below_baseline(0.999_999_999_999_999), "the baseline itself");
    }

    #[test]
    fn a_policy_beats_the_baseline_beyond_the_margin_and_by_its_interval() {
        let verdict = |value, low, high| Verdict::of(Interval { value, low, high });
        assert_eq!(verdict(0.98, 0.97, 0.995), Verdict::Beats);
        assert_eq!(verdict(0.98, 0.95, 1.001), Verdict::NoDifference);
        assert_eq!(verdict(0.991, 0.988, 0.995), Verdict::NoDifference);
        assert_eq!(verdict(1.02, 0.99, 1.04), Verdict::NoDifference);
        assert_eq!(verdict(1.02, 1.005, 1.04), Verdict::Worse);
        assert_eq!(
            [0.9, 1.0, 1.1].map(Verdict::of_one),
            [Verdict::Beats, Verdict::NoDifference, Verdict::Worse]
        );
    }

    #[test]
    fn scores_far_from_the_baseline_are_shown_with_fewer_decimals() {
        let shown =
            [0.87345, -0.0001, 9.9994, 9.9996, 99.94, 99.96, 53_261.163, f64::INFINITY].map(score_text);
        assert_eq!(shown, ["0.873", "0.000", "9.999", "10.0", "99.9", "100", "53261", "inf"]);
    }

    #[test]
    fn an_interval_contains_its_value_and_is_reproducible() {
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
    fn seeds_of_a_building_count_as_one_score_and_widen_the_interval() {
        let seeds =
            |spread: f64| vec![vec![vec![1.0 - spread, 1.0 + spread], vec![2.0 - spread, 2.0 + spread]]];
        let (steady, noisy) =
            (aggregate_clusters(&seeds(0.0), 0).unwrap(), aggregate_clusters(&seeds(0.4), 0).unwrap());
        assert_eq!((steady.episodes, steady.mean.value, noisy.mean.value), (2, 1.5, 1.5));
        assert_eq!((steady.mean.low, steady.mean.high), (1.0, 2.0));
        assert!(noisy.mean.low < 0.9 && noisy.mean.high > 2.1, "{noisy:?}");
    }

    #[test]
    fn the_interval_of_a_mean_matches_its_standard_error() {
        // Two strata of 60 and 40 scores; the variance of the mean is Σ n·s² / N², where s² has the divisor n.
        let scores = |count: usize, shift: f64| -> Vec<f64> {
            (0..count).map(|k| shift + (k as f64 * 0.754_877_666).fract()).collect()
        };
        let strata = [scores(60, 0.0), scores(40, 5.0)];
        let variance = |scores: &[f64]| {
            let mean = mean(scores);
            scores.iter().map(|score| (score - mean).powi(2)).sum::<f64>() / scores.len() as f64
        };
        let error =
            (strata.iter().map(|each| each.len() as f64 * variance(each)).sum::<f64>()).sqrt() / 100.0;
        let Interval { value, low, high } = aggregate(&strata, 3).unwrap().mean;
        for half in [value - low, high - value] {
            assert!((half / (1.959_964 * error) - 1.0).abs() < 0.06, "{half} against {error}");
        }
    }

    #[test]
    fn a_profile_rises_from_0_to_1_and_a_gap_is_a_difference_of_interquartile_means() {
        let alone = |scores: &[f64]| vec![scores.iter().map(|score| vec![*score]).collect::<Vec<_>>()];
        let (test, train) = (alone(&[0.5, 1.0, 1.5, 2.0]), alone(&[0.4, 0.8, 0.9, 1.6]));
        let shares: Vec<f64> =
            profile(&test, &[0.4, 0.5, 1.0, 1.7, 2.0], 0).iter().map(|each| each.share.value).collect();
        assert_eq!(shares, [0.0, 0.25, 0.5, 0.75, 1.0]);
        let gap = difference(&test, &train, 0).unwrap();
        assert!((gap.value - 0.4).abs() < 1e-12 && gap.low < 0.0 && gap.high > 0.8, "{gap:?}");
        assert_eq!(difference(&test, &[], 0), None);
    }

    #[test]
    fn the_mix_of_strata_is_preserved() {
        // Each stratum is constant: whatever is drawn, the mean is the same.
        let steady = aggregate(&[vec![1.0; 5], vec![3.0; 5]], 0).unwrap();
        assert_eq!((steady.mean.low, steady.mean.high), (2.0, 2.0));
        let mixed = aggregate(&[[vec![1.0; 5], vec![3.0; 5]].concat()], 0).unwrap();
        assert!(mixed.mean.low < 1.7 && mixed.mean.high > 2.3, "{mixed:?}");
    }

    #[test]
    fn an_infinite_score_does_not_spoil_the_aggregates() {
        let aggregate = aggregate(&[vec![0.5, 0.6, f64::INFINITY, 0.7]], 0).unwrap();
        assert_eq!(aggregate.mean.value, f64::INFINITY);
        assert!((aggregate.interquartile_mean.value - 0.65).abs() < 1e-12);
        assert!(!aggregate.mean.low.is_nan() && !aggregate.median.high.is_nan(), "{aggregate:?}");
    }
}
