//! Samplers of episodes.

pub(crate) mod faults;
pub(crate) mod population;

use std::path::PathBuf;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::setting::EpisodeSetting;
use b2b_env::Task;
use b2b_env::{Error, Result};

/// A draw of a sampler: the next episode of an environment.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Building, weather, days and task.
    pub setting: EpisodeSetting,
    /// Steps after which the episode is truncated; the whole run period if `None`.
    pub steps: Option<usize>,
}

/// Draws the episodes of environments. Every environment has its own random stream, so its episodes do not depend on
/// the speed of the others.
pub trait Sampler: Send {
    /// The next episode of an environment.
    ///
    /// # Errors
    /// [`Error::NoBuilding`] for an empty sampler; other errors if the episode cannot be created. The environment is
    /// then lost, and draws again at its next reset.
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw>;

    /// Discards earlier draws, because the random streams restart.
    fn restart(&mut self) {}
}

impl Sampler for Box<dyn Sampler> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        (**self).draw(environment, random)
    }

    fn restart(&mut self) {
        (**self).restart();
    }
}

impl<F: FnMut(usize, &mut ChaCha8Rng) -> Result<Draw> + Send> Sampler for F {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        self(environment, random)
    }
}

/// Settings assigned to the environments in turn, the same in every episode. Settings beyond the number of environments
/// are not drawn: see [`Rotating`].
#[derive(Clone, Debug)]
pub struct Fixed(pub Vec<EpisodeSetting>);

impl Sampler for Fixed {
    fn draw(&mut self, environment: usize, _: &mut ChaCha8Rng) -> Result<Draw> {
        let index = environment.checked_rem(self.0.len()).ok_or(Error::NoBuilding)?;
        Ok(Draw { setting: self.0[index].clone(), steps: None })
    }
}

/// Settings assigned to a number of environments in turn. If there are more settings than environments, each
/// environment cycles through several of them, one per episode.
#[derive(Clone, Debug)]
pub struct Rotating {
    settings: Vec<EpisodeSetting>,
    environments: usize,
    /// Number of episodes of each environment so far.
    episodes: Vec<usize>,
}

impl Rotating {
    /// Returns the settings for a number of environments.
    pub fn new(settings: Vec<EpisodeSetting>, environments: usize) -> Self {
        Self { settings, environments, episodes: vec![0; environments] }
    }
}

impl Sampler for Rotating {
    fn draw(&mut self, environment: usize, _: &mut ChaCha8Rng) -> Result<Draw> {
        if self.settings.is_empty() {
            return Err(Error::NoBuilding);
        }
        let rounds = self.settings.len().div_ceil(self.environments);
        let round = self.episodes[environment] % rounds;
        self.episodes[environment] += 1;
        let index = (environment + round * self.environments) % self.settings.len();
        Ok(Draw { setting: self.settings[index].clone(), steps: None })
    }

    fn restart(&mut self) {
        self.episodes.fill(0);
    }
}

/// Settings that are drawn with equal probability.
#[derive(Clone, Debug)]
pub struct AnyOf(pub Vec<EpisodeSetting>);

impl Sampler for AnyOf {
    fn draw(&mut self, _: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        if self.0.is_empty() {
            return Err(Error::NoBuilding);
        }
        let index = random.random_range(0..self.0.len());
        Ok(Draw { setting: self.0[index].clone(), steps: None })
    }
}

/// Samplers assigned to the environments round-robin, in equal shares.
pub struct RoundRobin(pub Vec<Box<dyn Sampler>>);

impl Sampler for RoundRobin {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let own = environment.checked_rem(self.0.len()).ok_or(Error::NoBuilding)?;
        self.0[own].draw(environment, random)
    }

    fn restart(&mut self) {
        self.0.iter_mut().for_each(|sampler| sampler.restart());
    }
}

/// Several samplers. Each draw comes from one of them, with a probability proportional to its weight.
pub struct Weighted(Vec<(f64, Box<dyn Sampler>)>);

impl Weighted {
    /// Creates a sampler from samplers and their weights.
    ///
    /// # Errors
    /// [`Error::Weight`] for a weight that is negative or not finite, and if all are 0.
    pub fn new(of: Vec<(f64, Box<dyn Sampler>)>) -> Result<Self> {
        let is_valid = |weight: f64| weight.is_finite() && weight >= 0.0;
        let wrong = of.iter().map(|(weight, _)| *weight).find(|weight| !is_valid(*weight));
        let total: f64 = of.iter().map(|(weight, _)| weight).sum();
        match wrong.or((total <= 0.0).then_some(total)) {
            Some(weight) => Err(Error::Weight(weight)),
            None => Ok(Self(of)),
        }
    }
}

impl Sampler for Weighted {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let total: f64 = self.0.iter().map(|(weight, _)| weight).sum();
        let mut left = random.random_range(0.0..total);
        let drawn = self.0.iter().position(|(weight, _)| {
            left -= weight;
            left < 0.0
        });
        let last = self.0.len() - 1;
        self.0[drawn.unwrap_or(last)].1.draw(environment, random)
    }

    fn restart(&mut self) {
        self.0.iter_mut().for_each(|(_, sampler)| sampler.restart());
    }
}

/// The draws of another sampler, each with one of several tasks.
#[derive(Clone, Debug)]
pub struct WithTask<S> {
    /// Sampler whose draws get a task.
    pub of: S,
    /// Tasks, with equal probability.
    pub tasks: Vec<Task>,
}

impl<S: Sampler> Sampler for WithTask<S> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let mut draw = self.of.draw(environment, random)?;
        if !self.tasks.is_empty() {
            let index = random.random_range(0..self.tasks.len());
            draw.setting.episode.task = self.tasks[index].clone();
        }
        Ok(draw)
    }

    fn restart(&mut self) {
        self.of.restart();
    }
}

/// The draws of another sampler, each with one of several weather files, for example of other years. Equipment
/// stays sized for the buildings' own weather.
#[derive(Clone, Debug)]
pub struct WithWeather<S> {
    /// Sampler whose draws get a weather file.
    pub of: S,
    /// Weather files (EPW), with equal probability; the buildings' own if there are none.
    pub files: Vec<PathBuf>,
}

impl<S: Sampler> Sampler for WithWeather<S> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let mut draw = self.of.draw(environment, random)?;
        if !self.files.is_empty() {
            let index = random.random_range(0..self.files.len());
            draw.setting.episode.weather = self.files[index].clone();
        }
        Ok(draw)
    }

    fn restart(&mut self) {
        self.of.restart();
    }
}

/// The draws of another sampler, each kept by an environment for several episodes.
#[derive(Clone, Debug)]
pub struct Kept<S> {
    of: S,
    episodes: u32,
    /// Current draw of each environment, with the number of remaining episodes.
    current: Vec<Option<(Draw, u32)>>,
}

impl<S> Kept<S> {
    /// Keeps each draw of `of` for `episodes` episodes; 0 counts as 1.
    pub fn new(of: S, episodes: u32) -> Self {
        Self { of, episodes: episodes.max(1), current: Vec::new() }
    }
}

impl<S: Sampler> Sampler for Kept<S> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        if self.current.len() <= environment {
            self.current.resize_with(environment + 1, || None);
        }
        let (draw, left) = match self.current[environment].take() {
            Some((draw, left)) if left > 0 => (draw, left),
            _ => (self.of.draw(environment, random)?, self.episodes),
        };
        self.current[environment] = Some((draw.clone(), left - 1));
        Ok(draw)
    }

    fn restart(&mut self) {
        self.current.clear();
        self.of.restart();
    }
}

/// The draws of another sampler, limited to random windows within their run periods. A window begins on one of a few
/// days, because each first day needs its own warm-up.
#[derive(Clone, Debug)]
pub struct Windows<S> {
    /// Sampler whose draws are limited.
    pub of: S,
    /// Minimum and maximum days of an episode.
    pub days: (u32, u32),
    /// Number of first days, evenly spread.
    pub starts: u32,
}

impl<S: Sampler> Sampler for Windows<S> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let mut draw = self.of.draw(environment, random)?;
        let episode = &mut draw.setting.episode;
        let (min_days, max_days) = self.days;
        let whole = episode.period.days();
        if min_days == 0 || min_days > max_days || max_days > whole {
            return Err(Error::Window { min_days, max_days, whole });
        }
        let room = whole - max_days;
        let starts = self.starts.clamp(1, room + 1);
        let start = random.random_range(0..starts) * room / (starts - 1).max(1);
        let days = random.random_range(min_days..=max_days);
        episode.period = episode.period.part(start, max_days);
        draw.steps = Some((days * 24 * episode.steps_per_hour) as usize);
        Ok(draw)
    }

    fn restart(&mut self) {
        self.of.restart();
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn an_empty_sampler_is_an_error() {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let samplers: [Box<dyn Sampler>; 4] = [
            Box::new(Fixed(vec![])),
            Box::new(AnyOf(vec![])),
            Box::new(RoundRobin(vec![])),
            Box::new(Rotating::new(vec![], 2)),
        ];
        for mut sampler in samplers {
            assert!(matches!(sampler.draw(0, &mut random), Err(Error::NoBuilding)));
        }
    }
}
