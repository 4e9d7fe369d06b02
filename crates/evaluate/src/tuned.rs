//! The tuned reactive controllers and the energy scale of a building's class: the reference of all scores in tasks with
//! targets.

use b2b_control::{Objective, ReactiveParameters};
use b2b_env::Task;

use crate::subject::{SiteInfo, Subject};

/// Returns the reactive controllers' tuned parameters for the building's type and climate zone and the task's
/// objective.
pub fn controller_parameters(subject: &Subject, site: &SiteInfo, task: &Task) -> ReactiveParameters {
    let prototype = subject.placement.is_prototype(&subject.name);
    ReactiveParameters::tuned(subject.class(site), prototype, Objective::of(task))
}

/// Returns the task with the energy scale τ_E of the building's type and climate zone.
pub fn task_for(subject: &Subject, site: &SiteInfo, task: &Task, steps_per_hour: u32) -> Task {
    let scale = task.scale_for(subject.class(site), steps_per_hour);
    Task { energy_scale: Some(scale), ..task.clone() }
}
