//! A model predictive controller that could run in a building: Guideline 36 under supervisory points, chosen every hour
//! by a search over a day on a model identified from the two weeks before (early in January: the last two of the year).
//!
//! 1. [`identify`] runs the guideline for two weeks while its equipment points (supply air temperatures, minimum flows
//!    and the economizer limit) move at random, for two or eight hours. Setpoints and start times stay the guideline's.
//! 2. From the hours, regressions estimate the effect of every level of a point on cost and discomfort: a [`Model`].
//!    They begin from what is known of buildings of the type: a [`Prior`].
//! 3. Every hour, [`Mpc`] forecasts outdoor temperatures and setpoints for the next 24 hours, and chooses the levels of
//!    lowest predicted cost at no more predicted discomfort than the guideline's. It carries out the first hour.
//!
//! An effect within its uncertainty counts as zero; without effects, the guideline stays as it is.

mod day_plan;
mod drivers;
mod fit;
mod hour;
mod identification;
mod kind;
mod model;
mod prior;
mod regression;
mod undisturbed;

use b2b_env::{Bands, Controller, Decisions, Forecast, PREVIEW_HOURS, Preview, Spaces};

use crate::guideline36::{Guideline36, Guideline36Parameters};
use crate::{Error, Result};
use day_plan::DayPlan;
use drivers::Drivers;
use hour::Site;
pub use identification::{IDENTIFICATION_HOURS, Observed, identify, observe};
pub(crate) use kind::Kind;
pub use model::{Effect, Model, Response};
pub use prior::{Prior, Priors};

/// Name of the kind.
const NAME: &str = "mpc";
/// Revision of identification and plan, for the results of evaluations: raised whenever actions change.
const REVISION: u32 = 2;
/// Errors of the weather forecast 24 hours ahead: the temperature's (K) and the radiation's, which the model does not
/// read.
const FORECAST_ERROR: Preview = Preview { temperature_error: 2.0, solar_error: 0.0, seed: 0 };

/// The guideline's sequences under a model predictive supervisor.
#[derive(Clone, Debug)]
pub struct Mpc {
    guideline: Guideline36,
    model: Model,
    site: Site,
    bands: Bands,
    forecast: Forecast,
    /// Outdoor temperatures and radiation of the next hours.
    weather: [[f64; PREVIEW_HOURS]; 2],
    plan: DayPlan,
    /// The shift of every point, as an index into the plan's shifts; `None` for one that stays the guideline's.
    shifts: Vec<Option<usize>>,
    values: Vec<f64>,
    steps_per_hour: usize,
    step: usize,
}

impl Mpc {
    /// Creates the sequences of a building under its model, with weather forecasts whose errors are drawn with a seed.
    ///
    /// # Errors
    /// [`Error::NotOperation`] for a task without bands; [`Error::Values`] for a model of other sequences or shifts;
    /// [`Error::Env`] if the weather file cannot be read.
    pub fn new(spaces: &Spaces, model: &Model, seed: u64) -> Result<Self> {
        model.check().map_err(|why| Error::Values { why })?;
        let task = || spaces.episode.task.to_string();
        let bands = Bands::of(spaces).ok_or_else(|| Error::NotOperation { name: NAME, task: task() })?;
        let guideline = Guideline36::new(spaces, &Guideline36Parameters::default());
        let plan = DayPlan::new(model);
        let points = guideline.supervisory_points();
        let shifts: Vec<_> = points.iter().map(|point| plan.shift(point.shift.described().0)).collect();
        Ok(Self {
            values: vec![0.0; points.len()],
            site: Site::of(spaces),
            forecast: Forecast::of(spaces, Preview { seed, ..FORECAST_ERROR })?,
            weather: [[0.0; PREVIEW_HOURS]; 2],
            model: model.clone(),
            steps_per_hour: spaces.episode.steps_per_hour as usize,
            step: 0,
            guideline,
            bands,
            plan,
            shifts,
        })
    }

    /// Plans a day and sets the points for its first hour.
    fn decide(&mut self, observation: &[f64]) {
        let (day, hour) = self.site.time(observation);
        let [temperatures, radiation] = &mut self.weather;
        self.forecast.write(day, hour, temperatures, radiation);
        for ahead in 0..PREVIEW_HOURS {
            let (setpoint, outdoor) = match ahead {
                0 => (self.site.heating_setpoint(observation), self.site.outdoor(observation)),
                _ => (
                    self.site.scheduled_setpoint(&self.bands, day, hour + ahead as f64),
                    temperatures[ahead - 1],
                ),
            };
            let of_day = (hour + ahead as f64) as usize % 24;
            let drivers = Drivers::new(outdoor, setpoint, self.model.setpoints);
            self.plan.expect(&self.model, ahead, of_day, drivers);
        }
        self.plan.choose();
        for (value, shift) in self.values.iter_mut().zip(&self.shifts) {
            *value = shift.map_or(0.0, |shift| self.plan.first(&self.model, shift));
        }
        self.guideline.supervise(&self.values);
    }
}

impl Controller for Mpc {
    fn reset(&mut self) {
        self.guideline.reset();
        self.step = 0;
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        if self.step.is_multiple_of(self.steps_per_hour) {
            self.decide(observation);
        }
        self.step += 1;
        self.guideline.act(observation, action);
    }

    fn record(&self) -> Option<&Decisions> {
        self.guideline.record()
    }
}
