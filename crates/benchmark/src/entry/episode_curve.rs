//! Scores by episode in a building.

use b2b_building::Period;
use serde::{Deserialize, Serialize};

use super::scores::{Performance, by_building, samples};
use crate::problem::Stage;
use b2b_evaluate::statistics::{Interval, aggregate};
use b2b_evaluate::{EpisodeInfo, EpisodeResult};

/// Scores by episode in a building, where a policy keeps its memory over consecutive episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeCurve {
    /// The episodes, in order.
    pub points: Vec<EpisodePoint>,
    /// Resolved score of the first episode minus the last episode's, interquartile mean over buildings and tasks; above
    /// 0, the last is better.
    pub improvement: Interval,
}

/// The performance in one of the episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodePoint {
    /// Its run period.
    pub period: String,
    /// Days in the building before it.
    pub days_before: u32,
    /// Performance over all buildings and tasks.
    pub performance: Performance,
}

/// Resolved scores of a policy minus a reference's in the same episodes, interquartile mean over buildings and tasks;
/// above 0, the reference is better. A reference with one seed, such as a deterministic policy, is compared with every
/// seed of the policy.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeDifference {
    /// Difference of the mean over a building's episodes; seeds that lack an episode are left out.
    pub all: Interval,
    /// Difference in each episode, in order.
    pub points: Vec<Interval>,
}

impl EpisodeDifference {
    /// Returns the difference in the episodes of a curve; `None` unless both have a scored row of one building and task,
    /// and of one seed if the reference has several, in all of them.
    pub fn of(curve: &EpisodeCurve, rows: &[EpisodeResult], reference: &[EpisodeResult]) -> Option<Self> {
        let periods: Vec<&str> = curve.points.iter().map(|point| point.period.as_str()).collect();
        let only = reference.first()?.info.seed;
        let has_one_seed = reference.iter().all(|row| row.info.seed == only);
        // The difference in the same building, with the same task and seed, in some periods; `None` if one is missing.
        let mean = |row: &EpisodeResult, periods: &[&str]| {
            let seed = row.info.seed;
            let score = |rows: &[EpisodeResult], seed, period: &str| {
                same_in(rows, row, seed, period)?.resolved_score()
            };
            let seed_of_reference = if has_one_seed { only } else { seed };
            let difference = |period: &&str| {
                Some(score(rows, seed, period)? - score(reference, seed_of_reference, period)?)
            };
            let sum = periods.iter().map(difference).sum::<Option<f64>>()?;
            Some(sum / periods.len() as f64)
        };
        let interval = |periods: &[&str]| {
            let groups = by_building(rows_in(rows, periods.first()?), |row| mean(row, periods));
            Some(aggregate(&samples(&groups))?.interquartile_mean)
        };
        Some(Self {
            all: interval(&periods)?,
            points: periods.iter().map(|period| interval(&[*period])).collect::<Option<_>>()?,
        })
    }
}

impl EpisodeCurve {
    /// Returns the curve over rows of consecutive run periods; `None` without such periods, or if one of them has no
    /// score.
    pub(super) fn of(rows: &[EpisodeResult], periods: &[Period]) -> Option<Self> {
        let (mut points, mut days_before) = (Vec::new(), 0);
        for period in periods {
            let name = period.to_string();
            let performance = Performance::of(Stage::Test, rows_in(rows, &name))?;
            points.push(EpisodePoint { period: name, days_before, performance });
            days_before += period.days();
        }
        let last = rows_in(rows, &points.last()?.period);
        let first = points.first()?.period.as_str();
        // Seeds are different agents.
        let score_in_first = |row: &EpisodeResult| same_in(rows, row, row.info.seed, first)?.resolved_score();
        let improvement = |row: &EpisodeResult| Some(score_in_first(row)? - row.resolved_score()?);
        let improvement = aggregate(&samples(&by_building(last, improvement)))?.interquartile_mean;
        Some(Self { points, improvement })
    }
}

/// Returns the row of a period and a seed with the building and task of another row.
fn same_in<'a>(
    rows: &'a [EpisodeResult],
    row: &EpisodeResult,
    seed: u64,
    period: &str,
) -> Option<&'a EpisodeResult> {
    let EpisodeInfo { building, task, .. } = &row.info;
    rows.iter().find(|EpisodeResult { info, .. }| {
        info.period == period && info.building == *building && info.task == *task && info.seed == seed
    })
}

fn rows_in<'a>(rows: &'a [EpisodeResult], period: &str) -> impl Iterator<Item = &'a EpisodeResult> + Clone {
    rows.iter().filter(move |row| row.info.period == period)
}
