//! The definition of an episode and its spaces.

pub(crate) mod action;
pub(crate) mod attributes;
pub(crate) mod morphology;
pub(crate) mod observation;
pub(crate) mod role_observation;
pub(crate) mod slots;

use std::path::PathBuf;
use std::sync::Arc;

use b2b_building::{Conditioning, Date, PreparedBuilding, RunPeriod};
use b2b_climate::EpwFile;
use serde::{Deserialize, Serialize};

use self::action::ActionSpace;
use self::observation::ObservationSpace;
use crate::faults::Impairment;
use crate::setpoints::Setpoints;
use crate::setpoints::band::Bands;
use crate::task::Task;
use crate::{Error, Result};

/// Zone time steps per hour that the engine accepts.
const STEPS_PER_HOUR: [u32; 12] = [1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60];

/// The definition of an episode, without the building.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeConfig {
    /// Weather file (EPW).
    pub weather: PathBuf,
    /// Days that the episode covers.
    pub period: RunPeriod,
    /// Zone time steps per hour, each one step of the environment.
    pub steps_per_hour: u32,
    /// Setpoints, comfort and reward.
    pub task: Task,
}

impl EpisodeConfig {
    /// Checks that the engine can run the episode and that the values of the task are valid.
    ///
    /// # Errors
    /// [`Error::StepsPerHour`]; the errors of [`Task::check`]; [`Error::Building`] if the weather file cannot be read;
    /// [`Error::WeatherRows`] and [`Error::WeatherDays`] if the file does not fit the episode.
    pub fn check(&self) -> Result<()> {
        if !STEPS_PER_HOUR.contains(&self.steps_per_hour) {
            return Err(Error::StepsPerHour(self.steps_per_hour));
        }
        self.check_weather()?;
        self.task.check()
    }

    /// Checks that the weather file has the days of the episode, and a row for every step if it has several an hour.
    fn check_weather(&self) -> Result<()> {
        let file = EpwFile::open(&self.weather).map_err(Error::building)?;
        let record = file.record().map_err(Error::building)?;
        let weather = || self.weather.clone();
        if ![1, self.steps_per_hour].contains(&record.intervals()) {
            return Err(Error::WeatherRows { weather: weather(), rows: record.intervals() });
        }
        let days = (0..self.period.days()).map(|day| self.period.date(day));
        let mut dates = days.chain([self.period.first(), self.period.last()]);
        let Some(missing) = dates.find(|date| !record.has(date.month_and_day())) else { return Ok(()) };
        let span = record.span().map(|days| days.map(Date::of_day));
        let span = span.map_or(String::new(), |[first, last]| format!(", only {first}..{last}"));
        Err(Error::WeatherDays { weather: weather(), missing, span })
    }

    /// Steps of the whole run period.
    pub fn steps(&self) -> usize {
        (self.period.days() * 24 * self.steps_per_hour) as usize
    }
}

/// A building in an episode, with its observation and action spaces.
#[derive(Debug)]
pub struct Spaces {
    /// The building, sized and controllable.
    pub building: Arc<PreparedBuilding>,
    /// Weather, period, time step and task.
    pub episode: EpisodeConfig,
    /// Names, units and bounds of the actuators.
    pub action: ActionSpace,
    /// Names, units and bounds of the observation.
    pub observation: ObservationSpace,
}

impl Bands {
    /// Returns the bands of a building in an episode; `None` if its task has targets instead.
    pub fn of(spaces: &Spaces) -> Option<Self> {
        let Spaces { building, episode: EpisodeConfig { period, task, .. }, .. } = spaces;
        let Setpoints::Band { band } = &task.setpoints else { return None };
        Some(Self::new(band.clone(), building, task.presence.is_scheduled(), period.calendar()))
    }
}

impl Spaces {
    /// The spaces of a prepared building in an episode, whose period is given the building's calendar.
    pub fn new(building: Arc<PreparedBuilding>, episode: EpisodeConfig) -> Self {
        let episode = EpisodeConfig { period: building.in_its_calendar(episode.period), ..episode };
        Self {
            action: ActionSpace::of(&building),
            observation: ObservationSpace::of(&building, episode.steps_per_hour, &episode.task),
            episode,
            building,
        }
    }

    /// The controlled zones in model order: the index of each in the building, which is also the slot of its
    /// temperature in the observation.
    pub fn controlled_zones(&self) -> impl Iterator<Item = usize> {
        let zones = self.building.zones.iter().enumerate();
        zones.filter(|(_, zone)| zone.conditioning != Conditioning::None).map(|(index, _)| index)
    }

    /// Removes the errors of faulty sensors from an episode's observations: the first is before the first step, the
    /// others at the ends of the steps.
    pub fn remove_sensor_errors<'a>(&self, observations: impl Iterator<Item = &'a mut [f64]>) {
        let Some(impairment) = Impairment::new(&self.episode.task.faults, &self.building) else { return };
        let zones = self.building.zones.len();
        for (step, observation) in observations.enumerate() {
            impairment.correct(step, &mut observation[..zones]);
        }
    }

    /// Steps of a whole episode.
    pub fn episode_steps(&self) -> usize {
        self.episode.steps()
    }

    /// The scale τ_E of the task's reward for this building: see [`Task::scale_for`].
    pub fn energy_scale(&self) -> f64 {
        self.episode.task.scale_for(self.building.class, self.episode.steps_per_hour)
    }
}
