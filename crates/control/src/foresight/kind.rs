//! The kind `foresight`.

use std::path::Path;

use b2b_workers::Episode;
use serde_json::Value;

use super::plan::SHIPPED;
use super::{Foresight, NAME, Planned, Schedule, SchedulePlan, ScheduleSearchOptions};
use crate::kind::{self, AnyController, Case};
use crate::parameter_set::{from_json, to_json};
use crate::{Error, Result};

/// The kind `foresight`. Its values are a schedule, or null: then it is the shipped one, or found by a search.
pub(crate) struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        NAME
    }

    fn help(&self) -> &'static str {
        "guideline36 under a schedule found by a search with perfect foresight: shipped, or minutes to find"
    }

    fn identity(&self) -> String {
        kind::shipped_identity(NAME, SHIPPED)
    }

    fn is_stochastic(&self) -> bool {
        true
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn plans(&self) -> bool {
        true
    }

    fn read(&self, path: &Path) -> Result<Value> {
        Ok(to_json(&SchedulePlan::read(path)?.schedule))
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        if case.values.is_null() {
            return Err(Error::NeedsEpisode { name: NAME });
        }
        let schedule: Schedule = from_json(case.values)?;
        Ok(Box::new(Foresight::new(case.spaces, &schedule)?))
    }

    fn plan(
        &self,
        case: &Case<'_>,
        episode: &mut Episode,
        step: &mut dyn FnMut(),
    ) -> Result<Option<Box<dyn AnyController>>> {
        if !case.values.is_null() {
            return self.make(case).map(Some);
        }
        let schedule = match SchedulePlan::shipped(&Planned::of(case.spaces)?) {
            Some(plan) => plan.schedule,
            None => {
                let options = ScheduleSearchOptions { seed: case.seed, ..ScheduleSearchOptions::default() };
                let (steps, episodes) = (case.spaces.episode_steps(), options.episodes(case.spaces)?);
                super::plan(episode, &options, None, &mut kind::spread(steps, episodes, step))?.schedule
            }
        };
        Ok(Some(Box::new(Foresight::new(case.spaces, &schedule)?)))
    }
}
