//! An episode that ended, and its file.

use b2b_env::{EpisodeMetrics, Inputs, Metrics, Spaces};
use serde::{Deserialize, Serialize};

use super::info::EpisodeInfo;
use super::recording::{Recording, controlled_zones};
use super::result::deviations::Deviations;
use super::result::hours::Hours;
use super::step_rewards::StepRewards;
use crate::return_terms::ReturnTerms;

/// A finished episode, or why it was lost.
pub type Outcome = std::result::Result<Finished, Lost>;

/// The reason why an episode was lost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{reason}")]
pub struct Lost {
    /// The reason.
    pub reason: String,
}

/// An episode that ran to its end: its file in the folder of an evaluation. Separate from
/// [`EpisodeResult`](super::EpisodeResult), because distributions and hourly values, which only reports read, would
/// fill the memory of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// The episode and its metrics.
    pub record: EpisodeRecord,
    /// Sums from which the return follows for every weight.
    pub terms: ReturnTerms,
    /// Distribution of deviations from target.
    pub deviations: Deviations,
    /// Distribution of the rewards of single steps.
    pub step_rewards: StepRewards,
    /// Hourly values.
    pub hours: Hours,
}

/// The part of an episode's file that is one object without nesting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// The episode.
    #[serde(flatten)]
    pub info: EpisodeInfo,
    /// Its metrics.
    #[serde(flatten)]
    pub metrics: EpisodeMetrics,
    /// Its model and weather.
    #[serde(flatten)]
    pub inputs: Inputs,
    /// SHA-256 of the observation, action and penalties of every step, as `b2b run` prints it.
    pub trajectory_hash: String,
}

impl Finished {
    /// Returns the record of a recorded episode.
    pub(super) fn new(
        info: EpisodeInfo,
        inputs: Inputs,
        spaces: &Spaces,
        metrics: &Metrics,
        recording: &Recording,
    ) -> Self {
        let (zones, trajectory_hash) = (controlled_zones(spaces), recording.trajectory.hash());
        let step_rewards = StepRewards::of(&recording.trajectory);
        let recording = &recording.with_true_temperatures(spaces);
        Self {
            record: EpisodeRecord { info, metrics: metrics.into(), inputs, trajectory_hash },
            terms: metrics.into(),
            deviations: Deviations::of(recording, &zones),
            step_rewards,
            hours: Hours::of(recording, &zones, spaces),
        }
    }
}
