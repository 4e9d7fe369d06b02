//! A schedule found for an episode, with the search's conditions and outcome.

use std::collections::BTreeMap;
use std::path::Path;

use b2b_building::RunPeriod;
use b2b_env::{Inputs, Spaces};
use serde::{Deserialize, Serialize};

use super::ScheduleSearchOptions;
use super::outcome::EpisodeUse;
use super::schedule::Schedule;
use crate::guideline36::REVISION;
use crate::parameter_set::read;
use crate::{Error, Result};

/// The plans that ship with the program, one per line.
pub(super) const SHIPPED: &str = include_str!("../../data/foresight.jsonl");

/// The episode of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Planned {
    /// Name of the building.
    pub building: String,
    /// Its model and weather.
    pub inputs: Inputs,
    /// Run period.
    pub period: RunPeriod,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// SHA-256 of the task.
    pub task_sha256: String,
    /// Revision of the sequences that the schedule shifts ([`REVISION`]).
    pub guideline36: u32,
}

/// Totals of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EpisodeTotal {
    /// Amount of the task's resource, usually cost, per m².
    pub used: f64,
    /// Discomfort, K·h per zone.
    pub discomfort: f64,
}

/// A schedule with its result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SchedulePlan {
    /// The episode.
    pub planned: Planned,
    /// Options of the search.
    pub options: ScheduleSearchOptions,
    /// Number of episodes that the search ran.
    pub episodes: usize,
    /// Guideline 36 without supervision.
    pub guideline: EpisodeTotal,
    /// Guideline 36 under the schedule.
    pub result: EpisodeTotal,
    /// Saving of each kind of shift, in predicted weather if the search ran there: the score without it minus the
    /// score, as a share of the guideline's cost.
    pub savings: BTreeMap<String, f64>,
    /// The schedule.
    pub schedule: Schedule,
}

impl Planned {
    /// Returns the episode of an environment.
    ///
    /// # Errors
    /// The errors of [`Inputs::of`].
    pub fn of(spaces: &Spaces) -> Result<Self> {
        let episode = &spaces.episode;
        Ok(Self {
            building: spaces.building.name.clone(),
            inputs: Inputs::of(spaces)?,
            period: episode.period,
            steps_per_hour: episode.steps_per_hour,
            task_sha256: episode.task.hash(),
            guideline36: REVISION,
        })
    }
}

impl EpisodeTotal {
    /// Returns an outcome in the unit of the task's resource.
    pub(super) fn of(outcome: &EpisodeUse, spaces: &Spaces) -> Self {
        let unit = spaces.energy_scale() / spaces.episode.task.energy_weight;
        Self { used: outcome.used() * unit, discomfort: outcome.discomfort() }
    }
}

impl SchedulePlan {
    /// Reads a plan from a JSON file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ParameterFile`] with the reason.
    pub fn read(path: &Path) -> Result<Self> {
        let plan: Self = read(path)?;
        let invalid = |why: String| Error::ParameterFile { path: path.to_owned(), why };
        plan.schedule.check().map_err(|error| invalid(error.to_string()))?;
        let revision = plan.planned.guideline36;
        if revision != REVISION {
            return Err(invalid(format!(
                "its schedule was found for revision {revision} of guideline36, which is {REVISION} here; search again with \
                 `b2b tune foresight`"
            )));
        }
        Ok(plan)
    }

    /// Returns the shipped plan for an episode, if there is one.
    pub fn shipped(planned: &Planned) -> Option<Self> {
        Self::all_shipped().find(|plan| plan.planned == *planned)
    }

    /// Returns the shipped plans.
    pub fn all_shipped() -> impl Iterator<Item = Self> {
        SHIPPED.lines().map(|line| serde_json::from_str(line).expect("a test reads all shipped plans"))
    }

    /// Returns the share of the guideline's cost that the plan saves.
    pub fn saving(&self) -> f64 {
        1.0 - self.result.used / self.guideline.used
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_plan_saves_at_no_more_discomfort() {
        for plan in SchedulePlan::all_shipped() {
            let Planned { building, period, .. } = &plan.planned;
            plan.schedule.check().unwrap();
            assert_eq!(plan.schedule.days.len(), period.days() as usize, "{building} {period}");
            assert_eq!(plan.planned.guideline36, REVISION, "{building} {period}: search again");
            assert!(plan.result.used <= plan.guideline.used, "{building} {period}");
            assert!(plan.result.discomfort <= plan.guideline.discomfort + 0.1 * f64::from(period.days()));
            assert_eq!(SchedulePlan::shipped(&plan.planned).as_ref(), Some(&plan), "one plan per episode");
        }
    }
}
