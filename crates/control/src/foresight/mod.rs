//! Guideline 36 under a schedule of its supervisory points that was found with perfect foresight of weather, occupants
//! and physics: the best cost at comfort that is known for an episode, not a bound.
//!
//! [`plan`] searches for the [`Schedule`] by running the episode again and again; [`Foresight`] carries it out. A
//! schedule moves what an operator could move: setpoints, start times, supply air temperatures, minimum flows and the
//! economizer, the same in all zones or by zone, for each block of a day. The loops of the guideline do the rest.

mod kind;
mod outcome;
mod plan;
mod predicted;
mod response;
mod schedule;
mod search;
mod trials;

use std::path::Path;
use std::sync::Arc;

use b2b_env::tariff::Tariff;
use b2b_env::{Controller, DataFile, Decisions, Spaces};
use b2b_workers::Episode;
use serde::{Deserialize, Serialize};

use crate::guideline36::{Guideline36, Guideline36Parameters};
use crate::{Error, Result};
pub(crate) use kind::Kind;
pub(crate) use outcome::Days;
pub use outcome::{DayUse, EpisodeUse};
pub use plan::{EpisodeTotal, Planned, SchedulePlan};
use predicted::Predicted;
pub use schedule::Schedule;
use schedule::Varied;
use search::{Effort, search};
use trials::{TrialRecord, Trials};

/// Name of the kind.
const NAME: &str = "foresight";
/// Episodes in the actual weather after a search in predicted weather: the guideline's and the schedule's.
const CARRIED_OUT: usize = 2;
/// Largest error of forecasts a day ahead, K.
const LARGEST_ERROR: f64 = 5.0;
/// Revision of the search: it resumes no record of another one, whose episodes had other schedules.
const SEARCH: u32 = 3;

/// The guideline's sequences under a schedule.
#[derive(Clone, Debug)]
pub struct Foresight {
    guideline: Guideline36,
    /// Values of the supervisory points by block of the episode.
    rows: Vec<Vec<f64>>,
    steps_per_block: usize,
    step: usize,
}

impl Foresight {
    /// Creates the sequences of a building under a schedule. After the last day, the last block stays in effect.
    ///
    /// # Errors
    /// [`Error::Values`] if the schedule does not fit the building.
    pub fn new(spaces: &Spaces, schedule: &Schedule) -> Result<Self> {
        let guideline = Guideline36::new(spaces, &Guideline36Parameters::default());
        let rows = schedule.rows(guideline.supervisory_points())?;
        let steps_per_block = (schedule.block_hours * spaces.episode.steps_per_hour) as usize;
        Ok(Self { guideline, rows, steps_per_block, step: 0 })
    }
}

impl Controller for Foresight {
    fn reset(&mut self) {
        self.guideline.reset();
        self.step = 0;
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        if self.step.is_multiple_of(self.steps_per_block)
            && let Some(row) = self.rows.get(self.step / self.steps_per_block)
        {
            self.guideline.supervise(row);
        }
        self.step += 1;
        self.guideline.act(observation, action);
    }

    fn record(&self) -> Option<&Decisions> {
        self.guideline.record()
    }
}

/// Options of the search for a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduleSearchOptions {
    /// Length of a block of the day, h; a divisor of 24.
    pub block_hours: u32,
    /// Number of rounds. Each runs 4 episodes, and 2 for every pair.
    pub rounds: usize,
    /// Mirrored pairs of a round.
    pub pairs: usize,
    /// Random seed of the search and of the errors of forecasts.
    pub seed: u64,
    /// Standard deviation of the error of outdoor temperatures forecast 24 hours ahead, 0 to 5 K. With an error, the
    /// search runs in the weather predicted at the midnight of each day, and its schedule in the actual weather.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub forecast_error: f64,
    /// Whether every zone and air handler has values of its own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_zone: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde expects")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Default for ScheduleSearchOptions {
    fn default() -> Self {
        Self { block_hours: 4, rounds: 6, pairs: 5, seed: 0, forecast_error: 0.0, by_zone: false }
    }
}

impl ScheduleSearchOptions {
    /// Returns the number of episodes that a search in a building runs.
    ///
    /// # Errors
    /// [`Error::Values`] for an invalid option.
    pub fn episodes(&self, spaces: &Spaces) -> Result<usize> {
        let varied = self.varied(spaces)?;
        let bounds = Schedule::bounds(&varied, self.block_hours);
        let searched = self.effort().episodes(&bounds, &Schedule::parts(&varied, self.block_hours));
        Ok(searched + if self.has_errors() { CARRIED_OUT } else { 0 })
    }

    fn has_errors(&self) -> bool {
        self.forecast_error > 0.0
    }

    /// Returns the episode in the weather that forecasts predict; `None` if they have no error.
    fn predicted(&self, actual: &Episode) -> Result<Option<Predicted>> {
        let &Self { forecast_error: error, seed, .. } = self;
        self.has_errors().then(|| Predicted::new(actual, error, seed)).transpose()
    }

    /// Checks the options for a building.
    ///
    /// # Errors
    /// [`Error::Values`] with the option and what is expected.
    fn check(&self, spaces: &Spaces) -> Result<()> {
        let &Self { block_hours, forecast_error, .. } = self;
        let wrong = |why: String| Err(Error::Values { why });
        if !24_u32.is_multiple_of(block_hours) {
            return wrong(format!("block_hours is {block_hours}; expected a divisor of 24"));
        }
        if !(0.0..=LARGEST_ERROR).contains(&forecast_error) {
            return wrong(format!("forecast_error is {forecast_error}; expected 0 to {LARGEST_ERROR} K"));
        }
        let tariff = spaces.episode.task.tariff.as_ref().filter(|_| self.has_errors());
        match tariff.map(DataFile::tariff).transpose()?.filter(Tariff::has_events) {
            Some(tariff) => wrong(format!(
                "forecast_error is {forecast_error}, but events of the tariff `{}` follow the actual weather; expected 0, or \
                 a tariff without events",
                tariff.name
            )),
            None => Ok(()),
        }
    }

    fn effort(&self) -> Effort {
        Effort { rounds: self.rounds, pairs: self.pairs, seed: self.seed }
    }

    /// Returns the shifts of a building.
    ///
    /// # Errors
    /// Same as [`ScheduleSearchOptions::check`].
    fn varied(&self, spaces: &Spaces) -> Result<Vec<Varied>> {
        self.check(spaces)?;
        let guideline = Guideline36::new(spaces, &Guideline36Parameters::default());
        Ok(Varied::of(guideline.supervisory_points(), self.by_zone))
    }
}

/// Searches for the schedule of an episode. With a `record` file, an interrupted search resumes. `done` is called after
/// every episode of the search.
///
/// # Errors
/// [`Error::NotOperation`]; [`Error::Values`] for an invalid option; [`Error::OtherTuning`] for the record of another
/// search; [`Error::Io`]; the errors of [`Episode`].
pub fn plan(
    episode: &mut Episode,
    options: &ScheduleSearchOptions,
    record: Option<&Path>,
    done: &mut dyn FnMut(),
) -> Result<SchedulePlan> {
    let spaces = Arc::clone(b2b_env::Environment::spaces(episode));
    let task = &spaces.episode.task;
    if !task.is_operation() || task.energy_weight <= 0.0 {
        return Err(Error::NotOperation { name: NAME, task: task.to_string() });
    }
    let (planned, varied) = (Planned::of(&spaces)?, options.varied(&spaces)?);
    let record = record.map(|path| TrialRecord::open(path, &(&planned, options, SEARCH))).transpose()?;
    let mut predicted = options.predicted(episode)?;
    let searched = predicted.as_mut().map_or(&mut *episode, |predicted| &mut predicted.episode);
    let mut trials = Trials::new(searched, record, done);
    let schedule = |point: &[Vec<f64>]| Schedule::of_point(&varied, options.block_hours, point);
    let mut episodes = 0;
    let mut run = |points: &[search::Point]| {
        episodes += points.len();
        points.iter().map(|point| trials.run(&schedule(point))).collect()
    };
    let parts = Schedule::parts(&varied, options.block_hours);
    let bounds = Schedule::bounds(&varied, options.block_hours);
    let days = spaces.episode.period.days() as usize;
    let mut found = search(&bounds, days, &parts, options.effort(), &mut run)?;
    if predicted.is_some() {
        let mut trials = Trials::new(episode, None, done);
        found.baseline = trials.run(&schedule(&vec![vec![0.0; bounds.len()]; days]))?;
        found.outcome = trials.run(&schedule(&found.point))?;
        episodes += CARRIED_OUT;
    }
    Ok(SchedulePlan {
        planned,
        options: *options,
        episodes,
        guideline: EpisodeTotal::of(&found.baseline, &spaces),
        result: EpisodeTotal::of(&found.outcome, &spaces),
        savings: Varied::kinds(&varied).into_iter().map(str::to_owned).zip(found.shares).collect(),
        schedule: schedule(&found.point),
    })
}
