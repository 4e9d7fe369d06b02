//! A row of a results table.

use b2b_env::EpisodeMetrics;

use super::finished::{Lost, Record};
use super::info::EpisodeInfo;
use super::step_rewards::StepRewards;
use crate::scores::normalized_score;

/// An episode in a results table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was run.
    pub info: EpisodeInfo,
    /// Its metrics and score, or why it was lost.
    pub outcome: Result<Scored, Lost>,
}

/// The metrics of an episode with its score.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scored {
    /// The metrics.
    pub metrics: EpisodeMetrics,
    /// Distribution of the rewards of single steps.
    pub step_rewards: StepRewards,
    /// SHA-256 of every observation, action and penalty.
    pub trajectory_hash: String,
    /// Return of the reactive controllers for the same episode, if known.
    pub baseline_return: Option<f64>,
    /// Return over that of the reactive controllers: see [`normalized_score`].
    pub score: Option<f64>,
}

impl Row {
    /// Scores an episode against the return of the reactive controllers.
    pub(crate) fn scored(record: Record, step_rewards: StepRewards, baseline_return: Option<f64>) -> Self {
        let Record { info, metrics, trajectory_hash } = record;
        let score = baseline_return.and_then(|baseline| normalized_score(metrics.episode_return, baseline));
        Self { info, outcome: Ok(Scored { metrics, step_rewards, trajectory_hash, baseline_return, score }) }
    }

    /// Returns the score, if the episode was not lost and has one.
    pub fn score(&self) -> Option<f64> {
        self.outcome.as_ref().ok()?.score
    }

    /// Returns the metrics, unless the episode was lost.
    pub fn metrics(&self) -> Option<&EpisodeMetrics> {
        Some(&self.outcome.as_ref().ok()?.metrics)
    }
}
