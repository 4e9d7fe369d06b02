//! Samplers of episodes.

use std::sync::Arc;

use b2b_building::{BuildingType, Date, RunPeriod};
use b2b_dataset::{BuildingId, Catalog, Places, Split};
use b2b_energyplus::install::Quiet;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::setting::{Setting, Source};
use crate::spaces::EpisodeConfig;
use crate::task::Task;
use crate::{Error, Result};

/// A draw of a sampler: the next episode of an environment.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Building, weather, days and task.
    pub setting: Setting,
    /// Steps after which the episode is truncated; the whole run period if `None`.
    pub steps: Option<usize>,
}

/// Draws the episodes of environments. Every environment has its own random stream, so that its episodes do not depend
/// on how fast the others are.
pub trait Sampler: Send {
    /// The next episode of an environment.
    ///
    /// # Errors
    /// When the episode cannot be made. The environment is lost then, and draws again at its next reset.
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw>;
}

impl<F: FnMut(usize, &mut ChaCha8Rng) -> Result<Draw> + Send> Sampler for F {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        self(environment, random)
    }
}

/// A setting for each environment, episode after episode.
#[derive(Clone, Debug)]
pub struct Fixed(pub Vec<Setting>);

impl Sampler for Fixed {
    fn draw(&mut self, environment: usize, _: &mut ChaCha8Rng) -> Result<Draw> {
        Ok(Draw { setting: self.0[environment % self.0.len()].clone(), steps: None })
    }
}

/// Settings to draw every episode from, with equal probability.
#[derive(Clone, Debug)]
pub struct AnyOf(pub Vec<Setting>);

impl Sampler for AnyOf {
    fn draw(&mut self, _: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let index = random.random_range(0..self.0.len());
        Ok(Draw { setting: self.0[index].clone(), steps: None })
    }
}

/// A population to draw the building of every episode from, generated when it is drawn.
#[derive(Clone, Debug)]
pub struct Buildings {
    /// Catalog that generates them.
    pub catalog: Arc<Catalog>,
    /// Population that they are drawn from.
    pub population: Population,
    /// Run period of an episode.
    pub period: RunPeriod,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Setpoints, comfort and reward.
    pub task: Task,
}

/// Buildings to draw from, with equal probability.
#[derive(Clone, Debug)]
pub enum Population {
    /// Buildings of the dataset.
    Ids(Vec<BuildingId>),
    /// New buildings of a type from the generator. No two are the same.
    Generated {
        /// Building type.
        building_type: BuildingType,
        /// Places of the buildings.
        places: Places,
        /// Parameters that are fixed or drawn from a narrower range.
        settings: Vec<b2b_dataset::Setting>,
    },
}

impl Population {
    /// The buildings of a type in the training or the test split.
    pub fn of_split(building_type: BuildingType, split: Split) -> Self {
        let rows = b2b_dataset::rows(building_type).iter().filter(|row| row.split == split);
        Self::Ids(rows.map(|row| row.id).collect())
    }

    fn draw(&self, random: &mut ChaCha8Rng) -> Result<(String, b2b_dataset::Building)> {
        match self {
            Self::Ids(ids) if ids.is_empty() => Err(Error::NoBuilding),
            Self::Ids(ids) => {
                let id = ids[random.random_range(0..ids.len())];
                Ok((id.to_string(), b2b_dataset::row(id).building.clone()))
            }
            Self::Generated { building_type, places, settings } => {
                let seed = random.random();
                let mut drawn = b2b_dataset::sample(*building_type, 1, seed, places, settings)?;
                let building = drawn.pop().ok_or(Error::NoBuilding)?;
                Ok((format!("{building_type}-seed{seed}-0001"), building))
            }
        }
    }
}

impl Sampler for Buildings {
    fn draw(&mut self, _: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let (name, building) = self.population.draw(random)?;
        let (model, weather) = self.catalog.generate(&building, &mut Quiet)?;
        let source = Source::generated(name, building.class(), model);
        let task = self.task.clone();
        let episode =
            EpisodeConfig { weather, period: self.period, steps_per_hour: self.steps_per_hour, task };
        Ok(Draw { setting: Setting { source: Arc::new(source), episode }, steps: None })
    }
}

/// Draws of another sampler, cut to random windows within their run periods. A window begins on one of a few days,
/// since each needs its own warm-up.
#[derive(Clone, Debug)]
pub struct Windows<S> {
    /// Sampler whose draws are cut.
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
