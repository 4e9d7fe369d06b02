//! Scores of a group of episodes.

use b2b_evaluate::EpisodeResult;
use b2b_evaluate::statistics::{is_below_baseline, median, score_text};

/// Scores of a group of episodes without lost ones.
pub(super) struct Group {
    /// In ascending order.
    scores: Vec<f64>,
    resolved: Vec<f64>,
}

impl Group {
    /// Returns `None` without a score.
    pub(super) fn of<'a>(rows: impl Iterator<Item = &'a EpisodeResult>) -> Option<Self> {
        let (mut scores, mut resolved): (Vec<f64>, Vec<f64>) =
            rows.filter_map(|row| Some((row.score()?, row.resolved_score()?))).unzip();
        scores.sort_by(f64::total_cmp);
        resolved.sort_by(f64::total_cmp);
        (!scores.is_empty()).then_some(Self { scores, resolved })
    }

    pub(super) fn count(&self) -> usize {
        self.scores.len()
    }

    pub(super) fn median(&self) -> f64 {
        median(&self.scores)
    }

    pub(super) fn resolved_median(&self) -> f64 {
        median(&self.resolved)
    }

    pub(super) fn min(&self) -> f64 {
        self.scores[0]
    }

    pub(super) fn max(&self) -> f64 {
        self.scores[self.scores.len() - 1]
    }

    /// Returns the number of scores below 1.
    pub(super) fn beats(&self) -> usize {
        self.scores.partition_point(|score| is_below_baseline(*score))
    }

    /// Returns median, resolved median, lowest and highest score, and the number below 1, as cells.
    pub(super) fn cells(&self) -> [String; 4] {
        [
            score_text(self.median()),
            score_text(self.resolved_median()),
            format!("{} to {}", score_text(self.min()), score_text(self.max())),
            format!("{}/{}", self.beats(), self.count()),
        ]
    }
}
