//! Populations of buildings to draw episodes from.

use std::collections::HashSet;
use std::sync::Arc;

use b2b_building::{BuildingType, Period};
use b2b_dataset::house::{Foundation, HouseSample};
use b2b_dataset::{Building, BuildingId, Catalog, Control, Places, Split};
use b2b_energyplus::install::Quiet;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Draw, Sampler};
use crate::setting::{EpisodeSetting, Source};
use b2b_env::EpisodeConfig;
use b2b_env::Task;
use b2b_env::{Error, Result};

/// Number of generated buildings among which one with each set of zones is sought.
const REPRESENTED: usize = 64;

/// A population from which the building of every episode is drawn, generated on demand.
#[derive(Clone, Debug)]
pub struct Buildings {
    /// Catalog that generates them.
    pub catalog: Arc<Catalog>,
    /// Population of the draws.
    pub population: Population,
    /// What an agent sets in them.
    pub control: Control,
    /// Run period of an episode.
    pub period: Period,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Setpoints, comfort and reward.
    pub task: Task,
}

/// Buildings that are drawn with equal probability.
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

    fn draw(&self, random: &mut ChaCha8Rng) -> Result<(String, Building)> {
        match self {
            Self::Ids(ids) if ids.is_empty() => Err(Error::NoBuilding),
            Self::Ids(ids) => {
                let id = ids[random.random_range(0..ids.len())];
                Ok((id.to_string(), b2b_dataset::row(id).building.clone()))
            }
            Self::Generated { building_type, places, settings } => {
                let seed = random.random();
                let mut drawn = b2b_dataset::sample(*building_type, 1, seed, places, settings)
                    .map_err(Error::building)?;
                let building = drawn.pop().ok_or(Error::NoBuilding)?;
                Ok((format!("{building_type}-seed{seed}-0001"), building))
            }
        }
    }
}

impl Buildings {
    /// A setting of a building.
    ///
    /// # Errors
    /// The errors of [`Catalog::generate`].
    pub fn setting(&self, name: String, building: &Building) -> Result<EpisodeSetting> {
        let (model, weather) = self.catalog.generate(building, &mut Quiet).map_err(Error::building)?;
        let name = name + self.control.suffix();
        let source = Source::generated(name, building.class(), model, weather.clone()).under(self.control);
        let (steps_per_hour, task) = (self.steps_per_hour, self.task.clone());
        let period = self.period.in_weather(&weather).map_err(Error::building)?;
        let episode = EpisodeConfig { weather, period, steps_per_hour, task };
        Ok(EpisodeSetting { source: Arc::new(source), episode })
    }
}

impl Sampler for Buildings {
    fn draw(&mut self, _: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let (name, building) = self.population.draw(random)?;
        Ok(Draw { setting: self.setting(name, &building)?, steps: None })
    }
}

/// Zones and actuators of a generated building. Buildings with the same set have the same spaces, except for bounds of
/// actuators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Shape {
    building_type: BuildingType,
    /// Of a house.
    crawlspace: bool,
    /// Of a house.
    garage: bool,
}

impl Shape {
    fn of(building: &Building) -> Self {
        let building_type = building.building_type();
        match building {
            Building::House(HouseSample { house, .. }) => {
                let crawlspace = house.foundation == Foundation::Crawlspace;
                Self { building_type, crawlspace, garage: house.garage }
            }
            Building::Commercial { .. } => Self { building_type, crawlspace: false, garage: false },
        }
    }
}

impl Population {
    /// Returns representative buildings, by name: one for each set of zones, from which the spaces of all buildings
    /// follow.
    ///
    /// # Errors
    /// The errors of [`b2b_dataset::sample`].
    pub fn representatives(&self) -> Result<Vec<(String, Building)>> {
        let all: Vec<(String, Building)> = match self {
            Self::Ids(ids) => {
                ids.iter().map(|id| (id.to_string(), b2b_dataset::row(*id).building.clone())).collect()
            }
            Self::Generated { building_type, places, settings } => {
                let drawn = b2b_dataset::sample(*building_type, REPRESENTED, 0, places, settings)
                    .map_err(Error::building)?;
                let name = |number| format!("{building_type}-seed0-{number:04}");
                (1..).map(name).zip(drawn).collect()
            }
        };
        let mut known = HashSet::new();
        Ok(all.into_iter().filter(|(_, building)| known.insert(Shape::of(building))).collect())
    }
}
