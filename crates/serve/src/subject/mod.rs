//! The served building, with its weather, task and baseline controller.

mod forecast;
mod forecast_errors;
mod points;
mod prices;
mod units;

use std::path::PathBuf;
use std::sync::Arc;

use b2b_building::{PreparedBuilding, RunPeriod};
use b2b_climate::TwoWeeks;
use b2b_control::{AnyController, Case, Kind};
use b2b_env::{EpisodeConfig, Spaces, Task};
use b2b_workers::{EpisodeSetting, Source};

pub(crate) use forecast::{Forecasts, WeatherErrors, series, times};
pub(crate) use forecast_errors::Uncertainty;
pub(crate) use points::Points;
pub(crate) use prices::{AllPrices, PriceScenario};

use crate::{Error, Result};

/// Days of a year.
pub(crate) const DAYS: u32 = 365;

/// The parts of a [`Subject`].
#[derive(Clone)]
pub struct SubjectOptions {
    /// The building.
    pub building: Arc<PreparedBuilding>,
    /// Its weather file.
    pub weather: PathBuf,
    /// The task, which has bands.
    pub task: Task,
    /// Control steps per hour.
    pub steps_per_hour: u32,
    /// The baseline controller, which sets the inputs that are not activated.
    pub controller: &'static dyn Kind,
}

/// A building that can be served.
pub struct Subject {
    options: SubjectOptions,
    source: Arc<Source>,
    /// First day of each two-week period; 1 is 1 January.
    two_weeks: Vec<(TwoWeeks, u32)>,
    /// Building, task and spaces; the period is the year.
    pub(crate) spaces: Spaces,
    pub(crate) points: Points,
    pub(crate) prices: AllPrices,
    pub(crate) forecasts: Forecasts,
}

impl Subject {
    /// Returns the subject with its points, prices and forecasts.
    ///
    /// # Errors
    /// [`Error::NoBands`], [`Error::TaskPart`], [`Error::Plans`] and [`Error::LeapDay`] for tasks, controllers and
    /// years that BOPTEST's interface cannot express; the errors of the weather file and of [`EpisodeConfig::check`].
    pub fn new(options: SubjectOptions) -> Result<Self> {
        check(&options)?;
        let SubjectOptions { building, weather, task, steps_per_hour, .. } = options.clone();
        let episode = EpisodeConfig { weather, period: RunPeriod::FULL_YEAR, steps_per_hour, task };
        episode.check()?;
        let spaces = Spaces::new(building, episode);
        let prices = AllPrices::new(spaces.building.calendar())?;
        let forecasts = Forecasts::new(&spaces)?;
        let first = |weeks: TwoWeeks| Some((weeks, weeks.first_day(forecasts.dry_bulbs())?));
        Ok(Self {
            two_weeks: TwoWeeks::ALL.into_iter().filter_map(first).collect(),
            source: Arc::new(Source::Prepared(Box::new(PreparedBuilding::clone(&options.building)))),
            points: Points::of(&spaces),
            options,
            spaces,
            prices,
            forecasts,
        })
    }

    /// Returns the name of the test case.
    pub fn name(&self) -> &str {
        &self.options.building.name
    }

    /// Returns the first day of a two-week period; 1 is 1 January.
    pub(crate) fn first_day(&self, weeks: TwoWeeks) -> Option<u32> {
        self.two_weeks.iter().find(|(each, _)| *each == weeks).map(|(_, day)| *day)
    }

    /// Returns the setting of an episode over some days.
    pub(crate) fn setting(&self, period: RunPeriod) -> EpisodeSetting {
        EpisodeSetting::new(Arc::clone(&self.source), EpisodeConfig { period, ..self.spaces.episode.clone() })
    }

    /// Returns the baseline controller of an episode.
    ///
    /// # Errors
    /// The errors of [`Kind::make`].
    pub(crate) fn baseline(&self, spaces: &Spaces) -> b2b_control::Result<Box<dyn AnyController>> {
        let kind = self.options.controller;
        let values = kind.tuned(&spaces.building, &spaces.episode.task);
        let mut controller = kind.make(&Case { spaces, action: &spaces.action, seed: 0, values: &values })?;
        controller.reset();
        Ok(controller)
    }
}

fn check(options: &SubjectOptions) -> Result<()> {
    let SubjectOptions { building, task, controller, .. } = options;
    if building.calendar().is_leap() {
        return Err(Error::LeapDay);
    }
    let part = |what, remedy| Err(Error::TaskPart { task: task.to_string(), what, remedy });
    if !task.is_operation() {
        return Err(Error::NoBands { task: task.to_string() });
    }
    if task.tariff.is_some() {
        return part("a tariff", "leave it out: clients choose prices with PUT /scenario");
    }
    if task.prices != Task::default().prices {
        return part("prices of its own", "leave them out: clients choose prices with PUT /scenario");
    }
    if task.preview.is_some() {
        return part("a preview", "leave it out: clients ask PUT /forecast");
    }
    if !task.faults.is_none() {
        return part("faults", "leave them out: the indicators would count errors of sensors");
    }
    match controller.plans() {
        true => Err(Error::Plans { name: controller.name() }),
        false => Ok(()),
    }
}
