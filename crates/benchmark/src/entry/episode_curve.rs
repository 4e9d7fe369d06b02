//! Scores by episode in a building.

use b2b_building::Period;
use serde::{Deserialize, Serialize};

use super::scores::{Performance, by_building, clusters};
use b2b_evaluate::EpisodeResult;
use b2b_evaluate::statistics::{Interval, aggregate_clusters};

/// Scores by episode in a building, where a policy keeps its memory over consecutive episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeCurve {
    /// The episodes, in order.
    pub points: Vec<EpisodePoint>,
    /// Resolved score of the first episode minus that of the last, interquartile mean over buildings and tasks; above 0, the
    /// last is better.
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

impl EpisodeCurve {
    /// Returns the curve over rows of consecutive run periods; `None` without such periods.
    pub(super) fn of(rows: &[EpisodeResult], periods: &[Period], seed: u64) -> Option<Self> {
        let (mut points, mut days_before) = (Vec::new(), 0);
        for period in periods {
            let performance = Performance::of(rows_in(rows, period), seed)?;
            points.push(EpisodePoint { period: period.to_string(), days_before, performance });
            days_before += period.days();
        }
        let scores = |period: &Period| by_building(rows_in(rows, period), EpisodeResult::resolved_score);
        let (first, last) = (scores(periods.first()?), scores(periods.last()?));
        let improvements: Vec<_> =
            first.iter().zip(&last).map(|(first, last)| first.improvement(last)).collect();
        let improvement = aggregate_clusters(&clusters(&improvements), seed)?.interquartile_mean;
        Some(Self { points, improvement })
    }
}

fn rows_in<'a>(
    rows: &'a [EpisodeResult],
    period: &Period,
) -> impl Iterator<Item = &'a EpisodeResult> + Clone {
    let period = period.to_string();
    rows.iter().filter(move |row| row.info.period == period)
}
