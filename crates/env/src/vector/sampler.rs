//! Which episode comes next.

use b2b_building::{Date, RunPeriod};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::pool::Setting;
use crate::{Error, Result};

/// An episode to come.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Building, weather, days and task.
    pub setting: Setting,
    /// Steps after which it is truncated; all of its run period if `None`.
    pub steps: Option<usize>,
}

/// Draws the episodes of environments. Every environment has a random stream of its own, so that what it gets does
/// not depend on how fast the others are.
pub trait Sampler: Send {
    /// The next episode of an environment.
    ///
    /// # Errors
    /// What keeps it from being made; the environment is lost then, and asks again at its next reset.
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw>;
}

impl<F: FnMut(usize, &mut ChaCha8Rng) -> Result<Draw> + Send> Sampler for F {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        self(environment, random)
    }
}

/// Every environment has a setting of its own, episode after episode.
#[derive(Clone, Debug)]
pub struct Fixed(pub Vec<Setting>);

impl Sampler for Fixed {
    fn draw(&mut self, environment: usize, _: &mut ChaCha8Rng) -> Result<Draw> {
        Ok(Draw { setting: self.0[environment % self.0.len()].clone(), steps: None })
    }
}

/// Every episode is one of these settings, each as likely as the others.
#[derive(Clone, Debug)]
pub struct AnyOf(pub Vec<Setting>);

impl Sampler for AnyOf {
    fn draw(&mut self, _: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let index = random.random_range(0..self.0.len());
        Ok(Draw { setting: self.0[index].clone(), steps: None })
    }
}

/// Draws of another sampler, cut to random windows of so many days within their run periods. A window begins on one
/// of a few days, since each needs a warm-up of its own.
#[derive(Clone, Debug)]
pub struct Windows<S> {
    /// What is cut.
    pub of: S,
    /// Least and most days of an episode.
    pub days: (u32, u32),
    /// How many first days there are, evenly spread.
    pub starts: u32,
}

impl<S: Sampler> Sampler for Windows<S> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let mut draw = self.of.draw(environment, random)?;
        let episode = &mut draw.setting.episode;
        let (least, most) = self.days;
        let whole = episode.period.days();
        if least == 0 || least > most || most > whole {
            return Err(Error::Window { least, most, whole });
        }
        let room = whole - most;
        let starts = self.starts.clamp(1, room + 1);
        let start = random.random_range(0..starts) * room / (starts - 1).max(1);
        let days = random.random_range(least..=most);
        let first = episode.period.first().day_of_year() + start;
        let [first, last] = [first, first + most - 1].map(Date::of_day);
        episode.period = RunPeriod::new(first, last).unwrap_or(episode.period);
        draw.steps = Some((days * 24 * episode.steps_per_hour) as usize);
        Ok(draw)
    }
}
