//! Resource use and discomfort of an episode under a schedule, by day.

use b2b_env::{Metrics, Observer, Step};
use serde::{Deserialize, Serialize};

/// Resource use and discomfort of an episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EpisodeUse {
    /// The days, in order.
    pub days: Vec<DayUse>,
}

/// Resource use and discomfort of a day.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DayUse {
    /// Use of the task's resource, usually cost, relative to the mean step of the building's class, times its weight.
    pub used: f64,
    /// Deviation outside the band integrated over time, K·h per zone.
    pub discomfort: f64,
}

impl EpisodeUse {
    /// Returns the use of the resource, relative to the mean step of the building's class, times its weight.
    pub fn used(&self) -> f64 {
        self.days.iter().map(|day| day.used).sum()
    }

    /// Returns the discomfort, K·h per zone.
    pub fn discomfort(&self) -> f64 {
        self.days.iter().map(|day| day.discomfort).sum()
    }
}

/// Adds up the penalties of an episode day by day.
#[derive(Debug)]
pub(crate) struct Days {
    steps_per_day: usize,
    steps: usize,
    /// The days so far. Until [`Days::outcome`], their discomfort is the comfort penalty.
    days: Vec<DayUse>,
}

impl Days {
    pub(crate) fn new(steps_per_hour: u32) -> Self {
        Self { steps_per_day: 24 * steps_per_hour as usize, steps: 0, days: Vec::new() }
    }

    /// Returns the outcome, with the episode's discomfort divided among the days in proportion to their comfort
    /// penalties.
    pub(crate) fn outcome(mut self, metrics: &Metrics) -> EpisodeUse {
        let penalty: f64 = self.days.iter().map(|day| day.discomfort).sum();
        let discomfort = metrics.zone_discomfort().unwrap_or(0.0);
        let scale = if penalty > 0.0 { discomfort / penalty } else { 0.0 };
        self.days.iter_mut().for_each(|day| day.discomfort *= scale);
        EpisodeUse { days: self.days }
    }
}

impl Observer for Days {
    fn step(&mut self, step: &Step<'_>) -> b2b_env::Result<()> {
        if self.steps.is_multiple_of(self.steps_per_day) {
            self.days.push(DayUse::default());
        }
        self.steps += 1;
        if let Some(day) = self.days.last_mut() {
            day.used += step.reward.energy_penalty;
            day.discomfort += step.reward.temperature_penalty;
        }
        Ok(())
    }
}
