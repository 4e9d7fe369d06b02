//! The tuned reactive controllers and the energy scale of a building's class: the reference of all scores.

use b2b_building::Class;
use b2b_control::{Objective, ReactiveParameters};
use b2b_energyplus::digest::sha256;
use b2b_env::Task;

use crate::subject::{SiteInfo, Subject};

/// Returns the parameters of the reactive controllers for a building and a task: those of its type and climate zone for the
/// objective of the task.
pub fn controller_parameters(subject: &Subject, site: &SiteInfo, task: &Task) -> ReactiveParameters {
    let prototype = subject.placement.is_prototype(&subject.name);
    ReactiveParameters::tuned(subject.class(site), prototype, Objective::of(task))
}

/// Returns the task with the energy scale τ_E of the building's type and climate zone.
pub fn task_for(subject: &Subject, site: &SiteInfo, task: &Task, steps_per_hour: u32) -> Task {
    let scale = task.scale_for(subject.class(site), steps_per_hour);
    Task { energy_scale: Some(scale), ..task.clone() }
}

/// Returns one hash of the parameters of all reactive controllers.
pub(crate) fn controllers_hash() -> String {
    let classes = Class::all().map(Some).chain([None]);
    let sets = classes
        .flat_map(|class| Objective::ALL.map(|objective| ReactiveParameters::tuned(class, false, objective)));
    let all: String = sets.map(|set| parameters_hash(&set)).collect();
    short(sha256(all))
}

/// Returns the hash of the parameters of one reactive controller.
pub(crate) fn parameters_hash(parameters: &ReactiveParameters) -> String {
    short(sha256(parameters.fingerprint()))
}

fn short(mut hash: String) -> String {
    hash.truncate(16);
    hash
}
