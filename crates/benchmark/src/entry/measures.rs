//! The measures of a benchmark run.

use b2b_building::Period;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::adaptation::Adaptation;
use super::episode_curve::EpisodeCurve;
use super::result::rows_of;
use super::scores::{Performance, Score, building_scores, by_building, from_random, samples};
use crate::problem::Stage;
use b2b_evaluate::EpisodeResult;
use b2b_evaluate::statistics::{Interval, Sample, Share, aggregate, difference, profile};

/// The measures of a run.
///
/// A *score* belongs to one building, task and run period: the return divided by the tuned reactive controllers'
/// return, averaged over seeds, as in the paper; in an operation task it is the score at comfort. Lower is better;
/// the baseline scores 1. Measures also have the resolved score, RMS deviation and energy; profile, gap and adaptation
/// use the paper's score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// Zero-shot performance on the test environments.
    pub test: Performance,
    /// The same by stratum, if there are several.
    pub strata: Vec<Stratum>,
    /// Performance profile: the share of test scores at or below each score.
    pub profile: Vec<Share>,
    /// The individual test scores.
    pub scores: Vec<Score>,
    /// Performance on training buildings, if it was tested on any.
    pub train: Option<Performance>,
    /// Generalization gap: interquartile mean on test buildings minus on training buildings; above 0 is worse on test.
    #[serde(rename = "generalisation_gap")]
    pub generalization_gap: Option<Interval>,
    /// Performance of specialists, each on the test building it was trained on, if there are any: an upper bound that
    /// is not ranked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper_bound: Option<Performance>,
    /// Adaptation to the test environments, if the policy adapts.
    pub adaptation: Option<Adaptation>,
    /// Performance by episode in a test building, if policies keep their memory over several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_episode: Option<EpisodeCurve>,
}

/// The performance in a stratum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stratum {
    /// The building type.
    pub building_type: String,
    /// The task.
    pub task: String,
    /// The run period.
    pub period: String,
    /// Performance.
    pub performance: Performance,
}

/// Returns the scores at which a profile is evaluated: 0 to 3 in steps of 0.05.
fn bounds() -> Vec<f64> {
    (0..=60).map(|step| f64::from(step) / 20.0).collect()
}

impl Measures {
    /// Returns the measures over the rows of every stage; `None` if the test stage has no score. `consecutive` are the
    /// run periods of [`Protocol::consecutive`](crate::problem::Protocol::consecutive).
    pub fn of(stages: &[(Stage, Vec<EpisodeResult>)], consecutive: &[Period]) -> Option<Self> {
        let test_rows = rows_of(stages, Stage::Test)?;
        let test = by_building(test_rows, EpisodeResult::score);
        let test_samples = samples(&test);
        let gap = |rows| difference(&test_samples, &samples(&by_building(rows, EpisodeResult::score)));
        let performance_of = |stage| rows_of(stages, stage).and_then(|rows| Performance::of(stage, rows));
        Some(Self {
            test: performance_of(Stage::Test)?,
            strata: Stratum::all(&test_samples, test_rows),
            profile: profile(&test_samples, &bounds()),
            scores: building_scores(test_rows),
            generalization_gap: rows_of(stages, Stage::Train).and_then(gap),
            train: performance_of(Stage::Train),
            upper_bound: performance_of(Stage::UpperBound),
            adaptation: Adaptation::of(stages, &test),
            by_episode: EpisodeCurve::of(test_rows, consecutive),
        })
    }
}

impl Stratum {
    /// Returns the strata in order of first appearance; none if there is only one.
    fn all(samples: &[Sample<'_>], rows: &[EpisodeResult]) -> Vec<Self> {
        let mut keys: Vec<[&str; 3]> = Vec::new();
        for Sample { building_type, case: [task, period], .. } in samples {
            let key = [*building_type, *task, *period];
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        let several = keys.len() > 1;
        keys.into_iter().filter(|_| several).filter_map(|key| Self::of(key, rows)).collect()
    }

    fn of([building_type, task, period]: [&str; 3], rows: &[EpisodeResult]) -> Option<Self> {
        let is_own = |row: &&EpisodeResult| {
            let info = &row.info;
            [&info.building_type[..], &info.task, &info.period] == [building_type, task, period]
        };
        let own: Vec<&EpisodeResult> = rows.iter().filter(is_own).collect();
        let performance = Performance::of(Stage::Test, own)?;
        let [building_type, task, period] = [building_type, task, period].map(str::to_owned);
        Some(Self { building_type, task, period, performance })
    }
}

/// Returns the interquartile mean of scores on the scale where random actions are at 0 and the baseline is at 1:
/// (S_random − S) / (S_random − 1), the same for scores and resolved scores. `None` if no building of the rows was run
/// under random actions that are worse than the baseline.
pub fn mean_from_random(rows: &[EpisodeResult], random: &[EpisodeResult]) -> Option<Interval> {
    Some(aggregate(&samples(&from_random(rows, random)))?.interquartile_mean)
}

/// Returns aggregates and profile of scores, as in [`Measures`]; `None` without scores. `resolved` has the resolved
/// scores of the same episodes.
pub fn measure_scores(scores: &[Sample<'_>], resolved: &[Sample<'_>]) -> Option<Value> {
    let mut test = json!(aggregate(scores)?);
    test["resolved"] = json!(aggregate(resolved)?);
    Some(json!({"test": test, "profile": profile(scores, &bounds())}))
}

#[cfg(test)]
mod tests {
    use super::super::episode_curve::EpisodeDifference;
    use super::*;
    use b2b_evaluate::{BuiltIn, Subject};
    use b2b_evaluate::{EpisodeInfo, EpisodePlan, Scored};

    /// Rows of 11 small and 6 medium offices with two seeds each, whose scores are a function of building and seed.
    fn rows(score: impl Fn(usize, u64) -> f64) -> Vec<EpisodeResult> {
        let places = (0..17).flat_map(|number| [0, 1].map(|seed| (number, seed)));
        let row = |(number, seed): (usize, u64)| {
            let building_type = if number < 11 { "OfficeSmall" } else { "OfficeMedium" };
            let episode = EpisodePlan {
                subject: Subject::at_home(format!("{building_type}-{}", number + 1).parse().unwrap()),
                task: "constant".parse().unwrap(),
                period: "01-01..01-02".parse().unwrap(),
                seed,
                steps_per_hour: 12,
            };
            let score = Some(score(number, seed));
            let scored = Scored { score, resolved_score: score, ..Scored::default() };
            EpisodeResult { info: EpisodeInfo::of(&episode, &BuiltIn::random()), outcome: Ok(scored) }
        };
        places.map(row).collect()
    }

    fn noise(number: usize, seed: u64) -> f64 {
        ((number as f64 + 1.0) * 12.9898 + seed as f64 * 78.233).sin().abs()
    }

    /// The mean over seeds of each building, computed independently of this module.
    fn means(score: impl Fn(usize, u64) -> f64) -> Vec<f64> {
        (0..17).map(|number| 0.5 * score(number, 0) + 0.5 * score(number, 1)).collect()
    }

    /// The interquartile mean as numpy and scipy define it, from ranks: 17 scores lose 4 at either end.
    fn trimmed(scores: &[f64]) -> f64 {
        let rank = |score: f64| scores.iter().filter(|other| **other < score).count();
        let kept: Vec<f64> = scores.iter().copied().filter(|score| (4..13).contains(&rank(*score))).collect();
        assert_eq!(kept.len(), 9);
        kept.iter().sum::<f64>() / 9.0
    }

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn measures_agree_with_an_independent_computation() {
        let test = |number, seed| 0.5 + noise(number, seed);
        let train = |number, seed| 0.3 + noise(number + 40, seed);
        let untrained = |number, seed| 3.0 + noise(number + 80, seed);
        // A third of the buildings are below 1 after 100 steps, all but two after 200.
        let first =
            |number: usize, seed| if number.is_multiple_of(3) { 0.9 } else { 1.1 + noise(number, seed) };
        let second = |number: usize, _| if number < 2 { 1.5 } else { 0.8 };
        let stages = [
            (Stage::Test, rows(test)),
            (Stage::Train, rows(train)),
            (Stage::Untrained, rows(untrained)),
            (Stage::Adapted(100), rows(first)),
            (Stage::Adapted(200), rows(second)),
        ];
        let measures = Measures::of(&stages, &[]).unwrap();
        let scores = means(test);
        near(measures.test.scores.mean.value, scores.iter().sum::<f64>() / 17.0);
        near(measures.test.scores.interquartile_mean.value, trimmed(&scores));
        let below = |score: f64| scores.iter().filter(|other| **other < score).count();
        near(measures.test.scores.median.value, *scores.iter().find(|score| below(**score) == 8).unwrap());
        near(measures.test.scores.beats_baseline.value, below(1.0) as f64 / 17.0);
        let sorted = |of: fn(f64, f64) -> f64| scores.iter().copied().reduce(of).unwrap();
        assert_eq!(measures.test.scores.beats_baseline_count, below(1.0));
        assert_eq!(
            (measures.test.scores.min, measures.test.scores.max),
            (sorted(f64::min), sorted(f64::max))
        );
        assert_eq!(measures.test.resolved, measures.test.scores);
        assert_eq!(
            (measures.scores.len(), measures.strata.len(), measures.strata[1].performance.scores.episodes),
            (17, 2, 6)
        );
        near(measures.scores[12].score, scores[12]);
        let at = |bound: f64| {
            measures.profile.iter().find(|point| (point.score - bound).abs() < 1e-12).unwrap().share
        };
        near(at(1.2).value, scores.iter().filter(|score| **score <= 1.2).count() as f64 / 17.0);
        near(measures.generalization_gap.unwrap().value, trimmed(&scores) - trimmed(&means(train)));

        let adaptation = measures.adaptation.unwrap();
        let better: Vec<f64> =
            means(untrained).iter().zip(&scores).map(|(before, after)| before - after).collect();
        near(adaptation.jump_start.value, trimmed(&better));
        let steps = |number: usize| match number {
            _ if scores[number] <= 1.0 => 0.0,
            _ if number.is_multiple_of(3) => 100.0,
            0 | 1 => f64::INFINITY,
            _ => 200.0,
        };
        let reach = (0..17).filter(|number| steps(*number) < f64::INFINITY).count();
        near(adaptation.reach_baseline, reach as f64 / 17.0);
        let earlier = |bound: f64| (0..17).filter(|number| steps(*number) < bound).count();
        let median = [0.0, 100.0, 200.0].into_iter().rfind(|bound| earlier(*bound) <= 8).unwrap();
        assert_eq!(adaptation.median_steps_to_baseline, Some(median));
        let curve: Vec<_> = adaptation.curve.iter().map(|point| point.steps).collect();
        assert_eq!(curve, [0, 100, 200]);
    }

    #[test]
    fn seeds_are_drawn_for_all_buildings_but_belong_to_a_specialist_s() {
        let rows = || rows(|_, seed| 1.0 + seed as f64);
        let measures = Measures::of(&[(Stage::Test, rows()), (Stage::UpperBound, rows())], &[]).unwrap();
        let interval = |performance: &Performance| performance.resolved.interquartile_mean;
        assert_eq!(interval(&measures.test), Interval { value: 1.5, low: 1.0, high: 2.0 });
        let specialists = measures.upper_bound.unwrap();
        assert_eq!(interval(&specialists), Interval { value: 1.5, low: 1.5, high: 1.5 });
    }

    #[test]
    fn a_policy_that_keeps_its_memory_is_scored_by_episode_in_a_building() {
        let periods = ["01-01..01-02", "01-03..01-09"].map(|period| period.parse::<Period>().unwrap());
        let (early, late) =
            (|number, seed| 1.3 + noise(number, seed), |number, seed| 0.8 + noise(number, seed));
        let mut episodes = rows(early);
        for mut row in rows(late) {
            row.info.period = periods[1].to_string();
            episodes.push(row);
        }
        let curve = Measures::of(&[(Stage::Test, episodes)], &periods).unwrap().by_episode.unwrap();
        let [first, last] = &curve.points[..] else { panic!("{curve:?}") };
        assert_eq!((first.days_before, last.days_before, last.period.as_str()), (0, 2, "01-03..01-09"));
        near(first.performance.resolved.interquartile_mean.value, trimmed(&means(early)));
        near(last.performance.scores.interquartile_mean.value, trimmed(&means(late)));
        // Every seed improves by the same, however much seeds differ from each other.
        let Interval { value, low, high } = curve.improvement;
        near(low, 0.5);
        near(high, 0.5);
        near(value, 0.5);
        assert_eq!(Measures::of(&[(Stage::Test, rows(early))], &[]).unwrap().by_episode, None);
    }

    #[test]
    fn policies_in_the_same_episodes_are_compared_by_building_and_seed() {
        let periods = ["01-01..01-02", "01-03..01-09"].map(|period| period.parse::<Period>().unwrap());
        let episodes = |above: [f64; 2]| {
            let of = |(period, above): (&Period, f64)| {
                let mut rows = rows(|number, seed| 1.0 + above + noise(number, seed));
                rows.iter_mut().for_each(|row| row.info.period = period.to_string());
                rows
            };
            periods.iter().zip(above).flat_map(of).collect::<Vec<_>>()
        };
        let (policy, reference) = (episodes([0.3, 0.1]), episodes([0.0, 0.0]));
        let curve = EpisodeCurve::of(&policy, &periods).unwrap();
        let EpisodeDifference { all, points } = EpisodeDifference::of(&curve, &policy, &reference).unwrap();
        for (found, expected) in [(points[0], 0.3), (points[1], 0.1), (all, 0.2)] {
            near(found.value, expected);
            assert!(found.high - found.low < 1e-9, "what both have in common cancels: {found}");
        }
        assert_eq!(EpisodeDifference::of(&curve, &policy, &[]), None);
    }

    #[test]
    fn random_actions_have_0_and_the_baseline_1_on_the_second_scale() {
        let random = |number, seed| 3.0 + noise(number, seed);
        let on_scale =
            |score: &dyn Fn(usize, u64) -> f64| mean_from_random(&rows(score), &rows(random)).unwrap().value;
        near(on_scale(&|_, _| 1.0), 1.0);
        near(on_scale(&random), 0.0);
        let halfway = means(random).iter().map(|random| (1.0 + random) / 2.0).collect::<Vec<_>>();
        near(on_scale(&|number, _| halfway[number]), 0.5);
        assert!(on_scale(&|_, _| 0.5) > 1.0);
        assert_eq!(mean_from_random(&rows(random), &[]), None);
        assert_eq!(mean_from_random(&rows(random), &rows(|_, _| 1.0)), None);
    }

    #[test]
    fn a_policy_that_never_reaches_the_baseline_has_no_steps_to_baseline() {
        let stages = [
            (Stage::Test, rows(|_, _| 2.0)),
            (Stage::Untrained, rows(|_, _| 3.0)),
            (Stage::Adapted(5), rows(|_, _| 1.5)),
        ];
        let adaptation = Measures::of(&stages, &[]).unwrap().adaptation.unwrap();
        assert_eq!((adaptation.median_steps_to_baseline, adaptation.reach_baseline), (None, 0.0));
        assert_eq!(adaptation.jump_start.value, 1.0);
        assert_eq!(Measures::of(&[], &[]), None);
    }
}
