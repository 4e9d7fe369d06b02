//! The identity of an episode in results.

use std::fmt;

use b2b_env::Spaces;
use serde::{Deserialize, Serialize};

use super::episode::EpisodePlan;
use crate::SiteInfo;
use crate::policy::Policy;

/// The description of an episode in results: building, task, run period, policy and seed. Unlike [`EpisodePlan`], it
/// contains only text and numbers, because results are also read where a user's model files are missing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeInfo {
    /// Name of the building.
    pub building: String,
    /// Building type; empty for a user's model.
    pub building_type: String,
    /// ASHRAE 169 climate zone.
    pub climate_zone: String,
    /// Place, or name of the weather file.
    pub place: String,
    /// `train` or `test`; empty for a building outside the dataset.
    pub split: String,
    /// Spelling of the task.
    pub task: String,
    /// SHA-256 of the task.
    pub task_hash: String,
    /// Run period, `MM-DD..MM-DD` or its name.
    pub period: String,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Name of the policy.
    pub policy: String,
    /// Seed of the policy.
    pub seed: u64,
}

impl EpisodeInfo {
    /// Returns the info of an episode that has not run: its site is unknown.
    pub fn of(episode: &EpisodePlan, policy: &dyn Policy) -> Self {
        let EpisodePlan { subject, task, period, seed, steps_per_hour } = episode;
        Self {
            building: subject.label(),
            building_type: subject.building_type().to_owned(),
            climate_zone: String::new(),
            place: String::new(),
            split: subject.split(),
            task: task.to_string(),
            task_hash: task.hash(),
            period: period.to_string(),
            steps_per_hour: *steps_per_hour,
            policy: policy.name(),
            seed: *seed,
        }
    }

    /// Returns the info of an episode that ran at a site.
    pub(super) fn of_run(
        episode: &EpisodePlan,
        policy: &dyn Policy,
        spaces: &Spaces,
        site: &SiteInfo,
    ) -> Self {
        Self {
            building: spaces.building.name.clone(),
            climate_zone: site.climate_zone.clone(),
            place: site.place.clone(),
            ..Self::of(episode, policy)
        }
    }

    /// Returns the site.
    pub fn site(&self) -> SiteInfo {
        SiteInfo { place: self.place.clone(), climate_zone: self.climate_zone.clone() }
    }
}

impl fmt::Display for EpisodeInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}, {}, seed {}", self.building, self.task, self.period, self.seed)
    }
}
