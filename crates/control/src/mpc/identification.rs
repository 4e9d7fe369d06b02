//! Identification: two weeks of the guideline with equipment points that move at random.

use std::sync::Arc;

use b2b_base::random::{stream, uniform};
use b2b_building::{Date, RunPeriod};
use b2b_env::{Controller, Environment, EpisodeConfig, Forecast, PREVIEW_HOURS, Preview, Spaces};
use b2b_workers::{Episode, EpisodeSetting};
use rand_chacha::ChaCha8Rng;

use super::NAME;
use super::drivers::Drivers;
use super::fit::fit;
use super::hour::{Hour, Site};
use super::model::{Model, shifts};
use super::prior::Prior;
use crate::guideline36::{Guideline36, Guideline36Parameters, Shift};
use crate::{Error, Result};

/// Levels of a shift: the guideline's choice and two others.
const LEVELS: usize = 3;
/// Days of the identification.
const DAYS: u32 = 14;
/// Hours of the identification.
pub const IDENTIFICATION_HOURS: usize = 24 * DAYS as usize;
/// First and last day of the identification for an episode in the first two weeks of a year.
const LAST_WEEKS: [u32; 2] = [352, 365];

/// Identifies the model of an episode's building in the two weeks before the episode, in an episode of their own. For
/// an episode that begins in the first two weeks of January, they are the last two weeks of December in the same
/// weather file. `done` is called after every hour.
///
/// # Errors
/// [`Error::NotOperation`] for a task without bands or without a weight of energy; the errors of [`Episode`], for
/// example if a weather file does not have these days.
pub fn identify(episode: &Episode, seed: u64, done: &mut dyn FnMut()) -> Result<Model> {
    let (period, observed) = observe(episode, seed, done)?;
    let building = &Environment::spaces(episode).building;
    let Observed { tried, hours } = observed;
    Ok(fit(&building.name, period.to_string(), (&tried, &hours), &Prior::of(building)))
}

/// Runs the two weeks before an episode under points that move at random. Returns them, and what happened.
///
/// # Errors
/// Same as [`identify`].
pub fn observe(episode: &Episode, seed: u64, done: &mut dyn FnMut()) -> Result<(RunPeriod, Observed)> {
    let own = &Environment::spaces(episode).episode;
    if !own.task.is_operation() || own.task.energy_weight <= 0.0 {
        return Err(Error::NotOperation { name: NAME, task: own.task.to_string() });
    }
    let period = before(own.period);
    let setting = EpisodeSetting {
        source: Arc::clone(&episode.setting().source),
        episode: EpisodeConfig { period, ..episode.setting().episode.clone() },
    };
    let mut weeks = episode.workers().episode(&setting)?;
    let spaces = Arc::clone(Environment::spaces(&weeks));
    Ok((period, run(&mut weeks, &spaces, seed, done)?))
}

/// What happened in an identification.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The shifts that were drawn.
    pub(super) tried: Vec<Shift>,
    pub(super) hours: Vec<Hour>,
}

/// Returns the two weeks before a period.
fn before(period: RunPeriod) -> RunPeriod {
    let first = period.first().day_of_year();
    let [from, to] = if first > DAYS { [first - DAYS, first - 1] } else { LAST_WEEKS };
    RunPeriod::new(Date::of_day(from), Date::of_day(to))
}

/// Runs an episode under points that move at random.
fn run(episode: &mut Episode, spaces: &Spaces, seed: u64, done: &mut dyn FnMut()) -> Result<Observed> {
    let mut guideline = Guideline36::new(spaces, &Guideline36Parameters::default());
    let site = Site::of(spaces);
    let owned: Vec<Shift> = guideline.supervisory_points().iter().map(|point| point.shift).collect();
    let tried: Vec<Shift> = shifts().filter(|shift| owned.contains(shift)).collect();
    let numbers: Vec<_> = owned.iter().map(|own| tried.iter().position(|shift| shift == own)).collect();
    let mut random = stream(NAME, seed, 0);
    let mut action = vec![0.0; spaces.action.len()];
    let mut observation = episode.reset()?.to_vec();
    let mut hours: Vec<Hour> = Vec::new();
    let [mut temperatures, mut radiation] = [[0.0; PREVIEW_HOURS]; 2];
    guideline.reset();
    let forecast = Forecast::of(spaces, Preview::default())?;
    let mut draws = Draws::new(tried.len());
    for number in 0..spaces.episode_steps() / spaces.episode.steps_per_hour as usize {
        draws.advance(number, &tried, &mut random);
        let levels = &draws.levels;
        let value = |number: &Option<usize>| {
            let number = (*number)?;
            let levels_of_shift = Drivers::levels(tried[number])?;
            levels[number].checked_sub(1).map(|level| levels_of_shift[level])
        };
        guideline.supervise(&numbers.iter().map(|own| value(own).unwrap_or(0.0)).collect::<Vec<_>>());
        let mut hour = site.begin(&observation, levels);
        let (day, of_day) = site.time(&observation);
        forecast.write(day, of_day, &mut temperatures, &mut radiation);
        hour.radiation = radiation[0];
        for _ in 0..spaces.episode.steps_per_hour {
            guideline.act(&observation, &mut action);
            site.deliver(&observation, &action, &mut hour);
            let step = episode.step(&action)?;
            hour.cost += step.reward.energy_penalty;
            hour.discomfort += step.reward.temperature_penalty;
            observation.copy_from_slice(step.observation);
            site.deviate(&observation, &mut hour);
        }
        hours.push(hour);
        done();
    }
    Ok(Observed { tried, hours })
}

/// Draws levels so that each occurs once in every three draws of a shift.
struct Draws {
    /// The level of every shift: 0 is the guideline's choice.
    levels: Vec<usize>,
    /// The order of the levels of every shift.
    orders: Vec<[usize; LEVELS]>,
}

impl Draws {
    fn new(shifts: usize) -> Self {
        Self { levels: vec![0; shifts], orders: vec![[0, 1, 2]; shifts] }
    }

    /// Sets the levels of an hour.
    fn advance(&mut self, hour: usize, tried: &[Shift], random: &mut ChaCha8Rng) {
        for ((level, order), shift) in self.levels.iter_mut().zip(&mut self.orders).zip(tried) {
            let turn = hour / Drivers::held(*shift) % LEVELS;
            if hour.is_multiple_of(LEVELS * Drivers::held(*shift)) {
                for last in (1..LEVELS).rev() {
                    order.swap(last, (uniform(random) * (last + 1) as f64) as usize);
                }
            }
            *level = order[turn];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_is_drawn_equally_often_and_the_draws_follow_the_seed() {
        let draw = |seed| {
            let (mut draws, mut random) = (Draws::new(2), stream(NAME, seed, 0));
            let mut next = |hour| {
                draws.advance(hour, &[Shift::SupplyTemperature, Shift::MinimumFlow], &mut random);
                draws.levels.clone()
            };
            (0..336).map(&mut next).collect::<Vec<_>>()
        };
        let drawn = draw(0);
        for (shift, level) in [(0, 0), (0, 2), (1, 1)] {
            assert_eq!(drawn.iter().filter(|levels| levels[shift] == level).count(), 112);
        }
        assert_eq!(drawn, draw(0));
        assert_ne!(drawn, draw(1));
    }

    #[test]
    fn the_identification_ends_on_the_day_before_the_episode_and_does_not_pass_new_year() {
        let of = |text: &str| before(text.parse().unwrap()).to_string();
        assert_eq!(of("02-01..02-14"), "01-18..01-31");
        assert_eq!(of("01-15..01-28"), "01-01..01-14");
        assert_eq!(of("01-14..01-27"), "12-18..12-31");
        assert_eq!(of("12-25..01-07"), "12-11..12-24");
    }
}
