//! Buildings to draw episodes from: listed, or created by the generator.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use b2b_building::Period;
use b2b_dataset::{BuildingId, Control};
use b2b_env::{EpisodeConfig, Spaces, Task};
use b2b_workers::{
    AnyOf, Buildings, EpisodeSetting, Fixed, Kept, Population, Sampler, Source, Weighted, Windows, WithTask,
    WithWeather,
};
use pyo3::prelude::*;

use crate::buildings::catalog::{Building, Inner, catalog, read_task};
use crate::buildings::generator::Generator;
use crate::interpreter::error::{Exception, of_building, of_env};

/// A building, or a source of buildings to draw from.
#[derive(FromPyObject)]
pub enum Candidate<'py> {
    /// A building that was found, generated or imported.
    Building(PyRef<'py, Building>),
    /// New buildings from the generator.
    Generator(PyRef<'py, Generator>),
    /// The id of a building of the dataset, which is generated when it is drawn.
    Id(String),
}

/// The buildings and tasks of a batch of environments.
pub struct Episodes {
    tasks: Vec<Task>,
    /// Control mode of generated buildings.
    control: Control,
    period: Period,
    steps_per_hour: u32,
    /// Buildings passed as objects.
    found: Vec<Arc<Inner>>,
    /// Buildings that are generated when they are drawn, with the name of their type.
    populations: BTreeMap<&'static str, Vec<Population>>,
}

impl Episodes {
    /// Reads the candidates, the tasks, the run period and the time step.
    pub fn new(
        candidates: &[Candidate<'_>],
        tasks: &[String],
        period: &str,
        steps_per_hour: u32,
        control: Control,
    ) -> PyResult<Self> {
        if tasks.is_empty() {
            return Err(Exception::Setting.new_err("task is empty; pass at least one"));
        }
        let tasks = tasks.iter().map(|task| read_task(task)).collect::<PyResult<Vec<_>>>()?;
        let period = period.parse().map_err(of_building)?;
        let mut ids = BTreeMap::<&'static str, Vec<BuildingId>>::new();
        let mut episodes =
            Self { tasks, control, period, steps_per_hour, found: Vec::new(), populations: BTreeMap::new() };
        for candidate in candidates {
            match candidate {
                Candidate::Building(building) => episodes.found.push(Arc::clone(&building.inner)),
                Candidate::Generator(generator) => episodes.add(generator.population()),
                Candidate::Id(text) => {
                    let id: BuildingId = text.parse().map_err(of_building)?;
                    ids.entry(id.building_type().name()).or_default().push(id);
                }
            }
        }
        ids.into_values().for_each(|ids| episodes.add(Population::Ids(ids)));
        Ok(episodes)
    }

    fn add(&mut self, population: Population) {
        let building_type = match &population {
            Population::Ids(ids) => ids[0].building_type(),
            Population::Generated { building_type, .. } => *building_type,
        };
        self.populations.entry(building_type.name()).or_default().push(population);
    }

    /// Returns a setting of each given building with the first task.
    fn found_settings(&self, of: &[Arc<Inner>]) -> PyResult<Vec<EpisodeSetting>> {
        let setting = |building: &Arc<Inner>| {
            let weather = building.weather().to_owned();
            let period = self.period.in_weather(&weather).map_err(of_building)?;
            let (steps_per_hour, task) = (self.steps_per_hour, self.tasks[0].clone());
            Ok(EpisodeSetting {
                source: building.source(),
                episode: EpisodeConfig { weather, period, steps_per_hour, task },
            })
        };
        of.iter().map(setting).collect()
    }

    /// Returns the pairs of building and task that environments repeat: all buildings with one task, then all with the
    /// next, up to `count` pairs.
    pub fn repeated(&self, count: usize) -> PyResult<Vec<(EpisodeSetting, Arc<Inner>)>> {
        let settings = self.found_settings(&self.found)?;
        let pair = |(task, number): (&Task, usize)| {
            let mut setting = settings[number].clone();
            setting.episode.task = task.clone();
            (setting, Arc::clone(&self.found[number]))
        };
        let numbers = |task| (0..settings.len()).map(move |number| (task, number));
        Ok(self.tasks.iter().flat_map(numbers).take(count).map(pair).collect())
    }

    fn generated(&self, population: &Population) -> PyResult<Buildings> {
        Ok(Buildings {
            catalog: catalog()?,
            population: population.clone(),
            control: self.control,
            period: self.period,
            steps_per_hour: self.steps_per_hour,
            task: self.tasks[0].clone(),
        })
    }

    /// Returns representative buildings, whose spaces determine the spaces of all buildings.
    pub fn representatives(&self) -> PyResult<Vec<EpisodeSetting>> {
        let mut known = BTreeSet::new();
        let differs = |building: &&Arc<Inner>| match building.building_type() {
            None => true,
            Some(building_type) => known.insert((building_type, zones(&building.source()))),
        };
        let found: Vec<_> = self.found.iter().filter(differs).cloned().collect();
        let mut settings = self.found_settings(&found)?;
        for population in self.populations.values().flatten() {
            let of = self.generated(population)?;
            for (name, building) in population.representatives().map_err(of_env)? {
                settings.push(of.setting(name, &building).map_err(of_env)?);
            }
        }
        Ok(settings)
    }

    /// Returns the spaces of a building with every task.
    pub fn under_every_task(&self, spaces: &Spaces) -> Vec<Arc<Spaces>> {
        let under = |task: &Task| {
            let episode = EpisodeConfig { task: task.clone(), ..spaces.episode.clone() };
            Arc::new(Spaces::new(Arc::clone(&spaces.building), episode))
        };
        self.tasks.iter().map(under).collect()
    }

    /// Returns a sampler of the buildings, each kept for `episodes` episodes. Without weights, all listed buildings
    /// have the same probability; a generator counts as one.
    pub fn sampler(
        &self,
        episodes: u32,
        weights: Option<&BTreeMap<String, f64>>,
        drawn: WeatherAndDays,
    ) -> PyResult<Box<dyn Sampler>> {
        let mut groups: Vec<(&str, f64, Box<dyn Sampler>)> = Vec::new();
        for (building_type, populations) in &self.populations {
            for population in populations {
                let size = match population {
                    Population::Ids(ids) => ids.len(),
                    Population::Generated { .. } => 1,
                };
                groups.push((building_type, size as f64, Box::new(self.generated(population)?)));
            }
        }
        for (building_type, found) in self.found_by_type() {
            let settings = self.found_settings(&found)?;
            groups.push((building_type, settings.len() as f64, Box::new(AnyOf(settings))));
        }
        if let Some(weights) = weights {
            weigh(&mut groups, weights)?;
        }
        let groups = groups.into_iter().map(|(_, weight, sampler)| (weight, sampler)).collect();
        let of = Weighted::new(groups).map_err(of_env)?;
        let tasks = if self.tasks.len() > 1 { self.tasks.clone() } else { Vec::new() };
        Ok(drawn.apply(Kept::new(WithTask { of, tasks }, episodes)))
    }

    fn found_by_type(&self) -> BTreeMap<&'static str, Vec<Arc<Inner>>> {
        let mut groups = BTreeMap::<_, Vec<_>>::new();
        for building in &self.found {
            let building_type = building.building_type().unwrap_or("imported");
            groups.entry(building_type).or_default().push(Arc::clone(building));
        }
        groups
    }
}

/// Returns the names of the zones of a building.
fn zones(source: &Source) -> Vec<String> {
    match source {
        Source::Prepared(building) => building.zones.iter().map(|zone| zone.name.clone()).collect(),
        Source::Model { model, .. } => model.names("Zone"),
    }
}

/// The weather and days that an episode draws, besides its building and task.
pub struct WeatherAndDays {
    /// Weather files to use instead of the buildings' own.
    pub weather_years: Vec<PathBuf>,
    /// Days of an episode and number of possible first days; whole run periods if `None`.
    pub window: Option<(u32, u32)>,
}

impl WeatherAndDays {
    /// Returns a sampler that repeats a setting in each environment.
    pub fn of_fixed(self, settings: Vec<EpisodeSetting>) -> Box<dyn Sampler> {
        self.apply(Fixed(settings))
    }

    fn apply(self, of: impl Sampler + 'static) -> Box<dyn Sampler> {
        let of = WithWeather { of, files: self.weather_years };
        match self.window {
            None => Box::new(of),
            Some((days, starts)) => Box::new(Windows { of, days: (days, days), starts }),
        }
    }
}

/// Divides the weight of each type among its groups in proportion to their numbers of buildings.
fn weigh(groups: &mut [(&str, f64, Box<dyn Sampler>)], weights: &BTreeMap<String, f64>) -> PyResult<()> {
    let known: BTreeSet<String> = groups.iter().map(|(name, ..)| (*name).into()).collect();
    if let Some(unknown) = weights.keys().find(|name| !known.contains(*name)) {
        let known = known.into_iter().collect::<Vec<_>>().join(", ");
        return Err(
            Exception::Setting.new_err(format!("unknown type `{unknown}` in weights; expected {known}"))
        );
    }
    let mut totals = BTreeMap::<String, f64>::new();
    groups.iter().for_each(|(name, size, _)| *totals.entry((*name).into()).or_default() += size);
    for (name, size, _) in groups {
        *size *= weights.get(*name).copied().unwrap_or(0.0) / totals[*name];
    }
    Ok(())
}
