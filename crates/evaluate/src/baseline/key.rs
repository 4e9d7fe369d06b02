//! The key of a baseline: everything that it depends on.

use b2b_base::digest::sha256;
use b2b_control::{Objective, parameters_hash};
use b2b_dataset::GENERATOR_VERSION;
use b2b_energyplus::install::ENGINE_VERSION;
use b2b_env::Task;
use serde::{Deserialize, Serialize};

use crate::evaluation::Episode;
use crate::tuned::controller_parameters;
use crate::{Result, SiteInfo};

/// Raised when a change to preparation, environments or controllers changes the reactive controllers' returns, so that
/// baselines cached before are not reused.
pub(super) const REVISION: u32 = 4;

/// Everything that a baseline depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key {
    /// [`Subject::identity`](crate::Subject::identity) of the building.
    pub building: String,
    /// The task without its energy term: spelling, with a hash where it has none.
    pub task: String,
    /// Objective of the controllers' parameters.
    pub objective: Objective,
    /// Run period.
    pub period: String,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Version of the building generator.
    pub generator: String,
    /// Version of EnergyPlus.
    pub engine: String,
    /// Hash of the controllers' parameters.
    pub controller: String,
    /// Revision of preparation, environments and controllers.
    pub revision: u32,
}

impl Key {
    /// Returns the key of an episode of a building at a site.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) for a user's file that cannot be read.
    pub fn of(episode: &Episode, site: &SiteInfo) -> Result<Self> {
        Ok(Self {
            building: episode.subject.identity()?,
            task: without_energy(&episode.task).to_string(),
            objective: Objective::of(&episode.task),
            period: episode.period.to_string(),
            steps_per_hour: episode.steps_per_hour,
            generator: GENERATOR_VERSION.to_owned(),
            engine: ENGINE_VERSION.to_owned(),
            controller: parameters_hash(&controller_parameters(&episode.subject, site, &episode.task)),
            revision: REVISION,
        })
    }

    /// Returns the name of the key's file in the cache.
    pub(super) fn file_name(&self) -> String {
        let json = serde_json::to_string(self).expect("plain data always serializes");
        format!("{}.json", &sha256(json)[..32])
    }
}

/// Returns a task without energy term and comfort band, which are not part of a baseline's key.
pub(super) fn without_energy(task: &Task) -> Task {
    let Task { energy_weight, energy_scale, resource, comfort_band, .. } = Task::default();
    Task { energy_weight, energy_scale, resource, comfort_band, ..task.clone() }
}
