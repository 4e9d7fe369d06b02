//! The key of a baseline: everything that it depends on.

use b2b_base::digest::sha256;
use b2b_control::{Objective, guideline36, kind_hash, parameters_hash};
use b2b_dataset::GENERATOR_VERSION;
use b2b_energyplus::install::ENGINE_VERSION;
use b2b_env::{Band, Comfort, DataFile, PMV_WEIGHT, Task};
use serde::{Deserialize, Serialize};

use crate::evaluation::EpisodePlan;
use crate::policy::BuiltIn;
use crate::tuned::controller_parameters;
use crate::{Result, SiteInfo};

/// Incremented when a change to preparation, environments or controllers changes the reactive controllers' returns, so
/// that older cached baselines are not reused. Baselines of operation tasks also depend on `guideline36`'s revision.
pub(super) const REVISION: u32 = 4;
/// Revision of tasks with sensor errors: thermostats have them, too, which changed these tasks alone.
const SENSORS_REVISION: u32 = REVISION + 1;
/// Maximum number of operation revisions per other revision.
const REVISIONS: u32 = 1000;

/// Everything that a baseline depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key {
    /// [`Subject::identity`](crate::Subject::identity) of the building.
    pub building: String,
    /// The task without its energy term: its spelling, or a hash if it has none.
    pub task: String,
    /// Objective of the reactive controllers' parameters; the guideline controller has one set for all.
    pub objective: Objective,
    /// Run period.
    pub period: String,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Version of the building generator.
    pub generator: String,
    /// Version of EnergyPlus.
    pub engine: String,
    /// Hash of the controllers' parameters and, for an operation task, of its tariff and emission profile.
    pub controller: String,
    /// Revision of preparation, environments and controllers.
    pub revision: u32,
}

impl Key {
    /// Returns the key of an episode of a building at a site.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) for a user's file that cannot be read.
    pub fn of(episode: &EpisodePlan, site: &SiteInfo) -> Result<Self> {
        let task = &episode.task;
        let has_errors = task.faults.noise > 0.0 || task.faults.bias > 0.0;
        let environments = if has_errors { SENSORS_REVISION } else { REVISION };
        let (objective, controller, revision) = match task.is_operation() {
            true => {
                let revision = environments * REVISIONS + guideline36::REVISION;
                (Objective::Energy, guideline36_hash(task), revision)
            }
            false => {
                let parameters = controller_parameters(&episode.subject, site, task);
                (Objective::of(task), parameters_hash(&parameters), environments)
            }
        };
        Ok(Self {
            building: episode.subject.identity()?,
            task: without_energy(task).to_string(),
            objective,
            period: episode.period.to_string(),
            steps_per_hour: episode.steps_per_hour,
            generator: GENERATOR_VERSION.to_owned(),
            engine: ENGINE_VERSION.to_owned(),
            controller,
            revision,
        })
    }

    /// Returns the name of the key's file in the cache.
    pub(super) fn file_name(&self) -> String {
        let json = serde_json::to_string(self).expect("plain data always serializes");
        format!("{}.json", &sha256(json)[..32])
    }
}

/// Returns the hash of the guideline controller's parameters, of the data that a task takes by name and of the weight of
/// votes, so that a baseline does not outlive a corrected tariff or weight.
fn guideline36_hash(task: &Task) -> String {
    let data = [&task.tariff, &task.emission_profile].into_iter().flatten().filter_map(DataFile::text);
    let weight = matches!(task.comfort, Comfort::Pmv(_)).then(|| PMV_WEIGHT.to_string());
    let data = data.map(str::to_owned).chain(weight);
    data.fold(kind_hash(BuiltIn::guideline36().kind()), |hash, text| sha256(hash + &text))
}

/// Returns the task without its energy term and comfort band, which are not part of a baseline's key. A task of
/// operation gets the comfort band of `operate` and loses its preview, which the guideline controller does not read.
pub(super) fn without_energy(task: &Task) -> Task {
    let usual = if task.is_operation() { Task::operate(Band::Own) } else { Task::default() };
    let Task { energy_weight, energy_scale, resource, comfort_band, preview, .. } = usual;
    Task { energy_weight, energy_scale, resource, comfort_band, preview, ..task.clone() }
}

/// Returns the task of the episode from which a baseline of an objective is computed.
pub(super) fn baseline_task(task: &Task, objective: Objective) -> Task {
    let plain = without_energy(task);
    if task.is_operation() { plain } else { objective.task(&plain) }
}
