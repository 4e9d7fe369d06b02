//! Aggregates of scores with confidence intervals, after the recommendations of Agarwal, Schwarzer, Castro, Courville
//! and Bellemare, "Deep Reinforcement Learning at the Edge of the Statistical Precipice", NeurIPS 2021 (rliable): the
//! interquartile mean in addition to median and mean, and percentile intervals of a stratified bootstrap, in which
//! buildings are drawn within their type, and the seeds of agents for all buildings ([`Sample`]).

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::any_number;
use crate::bootstrap::Design;
pub use crate::bootstrap::Sample;

/// Bootstrap resamples.
pub const DRAWS: usize = 5000;
/// Confidence level of the intervals.
pub const CONFIDENCE: f64 = 0.95;
/// Minimum number of buildings for an interval over buildings.
pub const FEWEST: usize = 3;
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
    /// Number of scores: of buildings, in each of several tasks and run periods.
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

/// Formats a number with two decimals, such as a ratio of energies; a dash if there is none.
pub fn ratio_text(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.2}"))
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

/// A point of a performance profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// A score.
    pub score: f64,
    /// Share of mean scores over seeds at or below it.
    pub share: Interval,
}

/// Aggregates scores; `None` without any. Each building counts once in every [`Sample::case`], with the mean over its
/// seeds.
pub fn aggregate(samples: &[Sample<'_>]) -> Option<Aggregate> {
    let design = Design::of(&[samples]);
    let measure = |scores: &[f64]| {
        vec![mean(scores), median(scores), interquartile_mean(scores), share_up_to(scores, is_below_baseline)]
    };
    let intervals = design.intervals(|lists| measure(sorted(&mut lists[0])))?;
    let [mean, median, interquartile_mean, beats_baseline] = intervals[..] else {
        return None;
    };
    let scores = design.means().concat();
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

/// Returns the performance profile: for each bound the share of scores at or below it.
pub fn profile(samples: &[Sample<'_>], bounds: &[f64]) -> Vec<Share> {
    let shares =
        |scores: &[f64]| bounds.iter().map(|bound| share_up_to(scores, |score| score <= *bound)).collect();
    let shares = Design::of(&[samples]).intervals(|lists| shares(&lists[0])).unwrap_or_default();
    bounds.iter().zip(shares).map(|(score, share)| Share { score: *score, share }).collect()
}

/// Returns the difference between the interquartile means of two sets of scores.
pub fn difference(above: &[Sample<'_>], below: &[Sample<'_>]) -> Option<Interval> {
    let interquartile_mean = |scores: &mut [f64]| interquartile_mean(sorted(scores));
    let measure =
        |lists: &mut [Vec<f64>]| vec![interquartile_mean(&mut lists[0]) - interquartile_mean(&mut lists[1])];
    Design::of(&[above, below]).intervals(measure)?.pop()
}

/// Returns a statistic of the sorted means over each building; `None` without a sample.
pub fn over_buildings(samples: &[Sample<'_>], statistic: impl Fn(&[f64]) -> f64) -> Option<Interval> {
    let samples: Vec<Sample<'_>> = samples.iter().map(|each| each.of_building()).collect();
    Design::of(&[&samples]).intervals(|lists| vec![statistic(sorted(&mut lists[0]))])?.pop()
}

/// Returns a statistic of the sorted differences between the means of two sets of samples over each building that has
/// both; `None` without one.
pub fn over_pairs(
    above: &[Sample<'_>],
    below: &[Sample<'_>],
    statistic: impl Fn(&[f64]) -> f64,
) -> Option<Interval> {
    fn common<'a>(own: &[Sample<'a>], other: &[Sample<'_>]) -> Vec<Sample<'a>> {
        let has = |each: &&Sample<'_>| other.iter().any(|other| other.building == each.building);
        own.iter().filter(has).map(|each| each.of_building()).collect()
    }
    let measure = |lists: &mut [Vec<f64>]| {
        let mut differences: Vec<f64> =
            lists[0].iter().zip(&lists[1]).map(|(above, below)| above - below).collect();
        vec![statistic(sorted(&mut differences))]
    };
    Design::of(&[&common(above, below), &common(below, above)]).intervals(measure)?.pop()
}

fn sorted(numbers: &mut [f64]) -> &[f64] {
    numbers.sort_by(f64::total_cmp);
    numbers
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

    /// Returns samples of buildings by type, each with its scores by seed.
    fn samples(types: &[Vec<Vec<f64>>]) -> Vec<Sample<'static>> {
        let name = |text: String| -> &'static str { text.leak() };
        let mut samples = Vec::new();
        for (number, buildings) in types.iter().enumerate() {
            let building_type = name(number.to_string());
            for (number, scores) in buildings.iter().enumerate() {
                let building = name(format!("{building_type}-{number}"));
                let of = |(seed, score): (u64, &f64)| Sample {
                    building_type,
                    building,
                    case: ["constant", "winter"],
                    agent: "",
                    seed,
                    score: *score,
                };
                samples.extend((0..).zip(scores).map(of));
            }
        }
        samples
    }

    /// Returns samples of buildings by type with a score each.
    fn alone(types: &[Vec<f64>]) -> Vec<Sample<'static>> {
        samples(
            &types.iter().map(|scores| scores.iter().map(|score| vec![*score]).collect()).collect::<Vec<_>>(),
        )
    }

    fn mean_of(samples: &[Sample<'_>]) -> Interval {
        aggregate(samples).unwrap().mean
    }

    #[test]
    fn an_interval_contains_its_value_and_is_reproducible() {
        let samples = alone(&[vec![0.9, 1.1, 1.0, 1.3], vec![2.0, 2.2, 2.1], vec![]]);
        let first = aggregate(&samples).unwrap();
        assert_eq!(aggregate(&samples), Some(first.clone()));
        assert_eq!(first.episodes, 7);
        for each in [first.mean, first.median, first.interquartile_mean] {
            assert!(each.low <= each.value && each.value <= each.high && each.low < each.high, "{each:?}");
        }
        assert_eq!(aggregate(&[]), None);
    }

    #[test]
    fn a_building_is_drawn_with_all_its_tasks_and_periods() {
        let once = alone(&[vec![0.5, 0.75, 1.25, 1.5]]);
        let weeks = ["week 1", "week 2", "week 3", "week 4"];
        let repeated: Vec<_> = once
            .iter()
            .flat_map(|each| weeks.map(|week| Sample { case: ["constant", week], ..*each }))
            .collect();
        let (once, repeated) = (aggregate(&once).unwrap(), aggregate(&repeated).unwrap());
        assert_eq!((once.mean, once.beats_baseline), (repeated.mean, repeated.beats_baseline));
        assert_eq!((once.episodes, repeated.episodes), (4, 16));
    }

    #[test]
    fn equal_scores_of_several_seeds_are_one_score() {
        let (once, six) =
            (alone(&[vec![1.0, 1.25, 1.5]]), samples(&[[1.0, 1.25, 1.5].map(|score| vec![score; 6]).into()]));
        assert_eq!(aggregate(&six), aggregate(&once));
        assert_eq!(mean_of(&once), Interval { value: 1.25, low: 1.0, high: 1.5 });
    }

    #[test]
    fn the_seeds_of_an_agent_are_drawn_once_for_all_buildings() {
        let shared = samples(&[vec![vec![0.75, 1.25]; 40]]);
        assert_eq!(mean_of(&shared), Interval { value: 1.0, low: 0.75, high: 1.25 });
        // The agents of other buildings are others: their seeds differ with the buildings.
        let own: Vec<_> = shared.iter().map(|each| Sample { agent: each.building, ..*each }).collect();
        assert_eq!(mean_of(&own), Interval { value: 1.0, low: 1.0, high: 1.0 });
        // With an agent for each type, all are seldom better at once.
        let types = samples(&vec![vec![vec![0.75, 1.25]; 3]; 4]);
        let by_type: Vec<_> =
            types.iter().map(|each| Sample { agent: each.building_type, ..*each }).collect();
        assert_eq!(mean_of(&types).low, 0.75);
        assert!(mean_of(&by_type).low > 0.75);
    }

    #[test]
    fn the_seeds_of_a_single_building_are_drawn() {
        let seeds = samples(&[vec![vec![0.5, 1.0, 1.5]]]);
        assert_eq!(mean_of(&seeds), Interval { value: 1.0, low: 0.5, high: 1.5 });
    }

    #[test]
    fn a_building_without_the_drawn_seeds_counts_with_its_own() {
        let lost = samples(&[vec![vec![1.0, 1.0], vec![3.0]]]);
        let Interval { value, low, high } = mean_of(&lost);
        assert_eq!((value, low, high), (2.0, 1.0, 3.0));
    }

    #[test]
    fn the_interval_of_a_mean_matches_its_standard_error() {
        // Two types of 60 and 40 scores; the variance of the mean is Σ n·s² / N², where s² has the divisor n.
        let scores = |count: usize, shift: f64| -> Vec<f64> {
            (0..count).map(|k| shift + (k as f64 * 0.754_877_666).fract()).collect()
        };
        let types = [scores(60, 0.0), scores(40, 5.0)];
        let variance = |scores: &[f64]| {
            let mean = mean(scores);
            scores.iter().map(|score| (score - mean).powi(2)).sum::<f64>() / scores.len() as f64
        };
        let error = (types.iter().map(|each| each.len() as f64 * variance(each)).sum::<f64>()).sqrt() / 100.0;
        let Interval { value, low, high } = mean_of(&alone(&types));
        for half in [value - low, high - value] {
            assert!((half / (1.959_964 * error) - 1.0).abs() < 0.06, "{half} against {error}");
        }
    }

    #[test]
    fn a_profile_rises_from_0_to_1_and_a_gap_is_a_difference_of_interquartile_means() {
        let test = alone(&[vec![0.5, 1.0, 1.5, 2.0]]);
        let train = alone(&[vec![0.4, 0.8, 0.9, 1.6]]);
        let train: Vec<_> = train.iter().map(|each| Sample { building_type: "train", ..*each }).collect();
        let shares: Vec<f64> =
            profile(&test, &[0.4, 0.5, 1.0, 1.7, 2.0]).iter().map(|each| each.share.value).collect();
        assert_eq!(shares, [0.0, 0.25, 0.5, 0.75, 1.0]);
        let gap = difference(&test, &train).unwrap();
        assert!((gap.value - 0.4).abs() < 1e-12 && gap.low < 0.0 && gap.high > 0.8, "{gap:?}");
        assert_eq!(difference(&test, &[]), None);
    }

    #[test]
    fn what_both_sides_of_a_difference_share_cancels() {
        let above = samples(&[vec![vec![1.0, 2.0], vec![3.0, 4.0], vec![5.0, 6.0], vec![9.0, 10.0]]]);
        let below: Vec<_> = above.iter().map(|each| Sample { score: each.score - 0.5, ..*each }).collect();
        let same = Interval { value: 0.5, low: 0.5, high: 0.5 };
        assert_eq!(difference(&above, &below), Some(same));
        assert_eq!(over_pairs(&above, &below[..4], median), Some(same), "two of four buildings");
    }

    #[test]
    fn the_mix_of_types_is_preserved() {
        // Each type is constant: whatever is drawn, the mean is the same.
        let steady = mean_of(&alone(&[vec![1.0; 5], vec![3.0; 5]]));
        assert_eq!((steady.low, steady.high), (2.0, 2.0));
        let mixed = mean_of(&alone(&[[vec![1.0; 5], vec![3.0; 5]].concat()]));
        assert!(mixed.low < 1.7 && mixed.high > 2.3, "{mixed:?}");
    }

    #[test]
    fn types_with_few_buildings_are_drawn_together() {
        let single = mean_of(&alone(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|score| vec![score])));
        assert!(single.low < 2.5 && single.high > 4.5, "{single:?}");
    }

    #[test]
    fn an_infinite_score_does_not_spoil_the_aggregates() {
        let scores = [0.5, 0.6, f64::INFINITY, 0.7].map(|score| vec![score, 0.6]);
        let aggregate = aggregate(&samples(&[scores.into()])).unwrap();
        assert_eq!(aggregate.mean.value, f64::INFINITY);
        assert!((aggregate.interquartile_mean.value - 0.625).abs() < 1e-12);
        assert!(!aggregate.mean.low.is_nan() && !aggregate.median.high.is_nan(), "{aggregate:?}");
    }
}
