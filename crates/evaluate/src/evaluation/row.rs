//! A row of a results table.

use b2b_env::{EpisodeMetrics, Inputs};
use serde::{Deserialize, Serialize};

use super::finished::{Lost, Record};
use super::info::EpisodeInfo;
use super::step_rewards::StepRewards;
use crate::scores::Baseline;

/// An episode in a results table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The episode.
    pub info: EpisodeInfo,
    /// Its metrics and score, or why it was lost.
    pub outcome: Result<Scored, Lost>,
}

/// The metrics of an episode with its score.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    /// The metrics.
    pub metrics: EpisodeMetrics,
    /// Distribution of the rewards of single steps.
    pub step_rewards: StepRewards,
    /// Its model and weather.
    pub inputs: Inputs,
    /// SHA-256 of every observation, action and penalty.
    pub trajectory_hash: String,
    /// Return of the reactive controllers for the same episode, if known.
    pub baseline_return: Option<f64>,
    /// HVAC energy of the reactive controllers in the same episode, Wh/m², if known.
    pub baseline_energy: Option<f64>,
    /// Return relative to the reactive controllers, as in the paper: see [`normalized_score`](crate::normalized_score).
    pub score: Option<f64>,
    /// See [`resolved_score`](crate::resolved_score).
    pub resolved_score: Option<f64>,
}

impl Row {
    /// Scores an episode against the reactive controllers.
    pub(crate) fn scored(record: Record, step_rewards: StepRewards, baseline: Option<Baseline>) -> Self {
        let Record { info, metrics, inputs, trajectory_hash } = record;
        let EpisodeMetrics { episode_return, steps, .. } = metrics;
        let scored = Scored {
            baseline_return: baseline.map(|baseline| baseline.episode_return),
            baseline_energy: baseline.map(|baseline| baseline.energy),
            score: baseline.and_then(|baseline| baseline.score(episode_return)),
            resolved_score: baseline.and_then(|baseline| baseline.resolved_score(episode_return, steps)),
            metrics,
            step_rewards,
            inputs,
            trajectory_hash,
        };
        Self { info, outcome: Ok(scored) }
    }

    /// Returns the score, if the episode was not lost and has one.
    pub fn score(&self) -> Option<f64> {
        self.outcome.as_ref().ok()?.score
    }

    /// Returns the resolved score, if the episode was not lost and has one.
    pub fn resolved_score(&self) -> Option<f64> {
        self.outcome.as_ref().ok()?.resolved_score
    }

    /// Returns the metrics, unless the episode was lost.
    pub fn metrics(&self) -> Option<&EpisodeMetrics> {
        Some(&self.outcome.as_ref().ok()?.metrics)
    }
}

impl Scored {
    /// Returns HVAC energy relative to the reactive controllers; `None` if theirs is unknown or 0.
    pub fn relative_energy(&self) -> Option<f64> {
        let baseline = self.baseline_energy.filter(|energy| *energy > 0.0)?;
        Some(self.metrics.energy() / baseline)
    }
}

/// Returns the sum of HVAC energy over that of the reactive controllers; `None` if theirs is unknown or 0. Of sums, so that
/// an episode with next to no energy counts next to nothing.
pub fn relative_energy<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Option<f64> {
    let (mut energy, mut baseline) = (0.0, 0.0);
    for scored in rows.into_iter().filter_map(|row| row.outcome.as_ref().ok()) {
        let Some(of_baseline) = scored.baseline_energy else { continue };
        energy += scored.metrics.energy();
        baseline += of_baseline;
    }
    (baseline > 0.0).then(|| energy / baseline)
}
