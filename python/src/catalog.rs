//! Buildings: found by name, generated, or the user's own.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use b2b_benchmark::{Subject, Surroundings};
use b2b_building::description::Origin;
use b2b_building::{BuildingType, Class};
use b2b_climate::{Place, WeatherFile};
use b2b_dataset::{BuildingName, Catalog, Placement, Places, manifest};
use b2b_energyplus::install::look_in;
use b2b_env::vector::{AnyOf, Draw, Sampler, Source, Windows};
use b2b_env::{EpisodeConfig, Task, vector};
use pyo3::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::error::{of_building, of_env};
use crate::pools::Signals;

/// A value that no panic spoils.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The engine and what models are made from, loaded when first needed.
pub fn catalog() -> PyResult<Arc<Catalog>> {
    static CATALOG: Mutex<Option<Arc<Catalog>>> = Mutex::new(None);
    let mut known = locked(&CATALOG);
    if let Some(catalog) = &*known {
        return Ok(Arc::clone(catalog));
    }
    if let Some(folder) = site_packages()? {
        look_in(folder);
    }
    let catalog = Arc::new(Catalog::open(&mut Signals).map_err(of_building)?);
    Ok(Arc::clone(known.insert(catalog)))
}

/// Where the package client put this package, and the engine beside it.
fn site_packages() -> PyResult<Option<PathBuf>> {
    Python::attach(|py| py.import("building2building._engine")?.call_method0("folder")?.extract())
}

/// The engine's library.
pub fn library() -> PyResult<PathBuf> {
    Ok(catalog()?.library().path().to_owned())
}

/// A building with its weather, before it is an environment.
#[pyclass(frozen, module = "building2building._core")]
pub struct Building {
    /// For the crates.
    pub inner: Arc<Inner>,
}

/// What settings of the building share.
pub struct Inner {
    name: String,
    class: Option<Class>,
    place: String,
    weather: PathBuf,
    pub origin: Origin,
    parameters: BTreeMap<String, String>,
    source: Mutex<Arc<Source>>,
}

impl Inner {
    /// A building of an evaluation, as it was prepared.
    pub fn of_subject(subject: &Subject, surroundings: &Surroundings, spaces: &b2b_env::Spaces) -> Self {
        let source = Source::Prepared(Box::new((*spaces.building).clone()));
        let (place, weather) = (surroundings.place.clone(), spaces.episode.weather.clone());
        let origin = subject.placement.origin(&subject.name);
        Self::new(source, spaces.building.class, place, weather, origin).with_parameters(&subject.name)
    }

    /// With its row of the dataset's table.
    fn with_parameters(mut self, name: &BuildingName) -> Self {
        if let BuildingName::Id(id) = name {
            self.parameters = cells(manifest::manifest([b2b_dataset::row(*id)]));
        }
        self
    }

    /// `class` is what it is of; `None` for a model of the user's own.
    fn new(source: Source, class: Option<Class>, place: String, weather: PathBuf, origin: Origin) -> Self {
        let name = source.name().to_owned();
        let source = Mutex::new(Arc::new(source));
        Self { name, class, place, weather, origin, parameters: BTreeMap::new(), source }
    }

    fn source(&self) -> Arc<Source> {
        Arc::clone(&locked(&self.source))
    }

    /// Keeps what was prepared of it, so that no other environment has to.
    pub fn keep(&self, spaces: &b2b_env::Spaces) {
        let mut source = locked(&self.source);
        if matches!(**source, Source::Model { .. }) {
            *source = Arc::new(Source::Prepared(Box::new((*spaces.building).clone())));
        }
    }
}

#[pymethods]
impl Building {
    /// Name, such as `OfficeSmall-0042`.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Type; `None` for a model of the user's own.
    #[getter]
    fn building_type(&self) -> Option<&'static str> {
        self.inner.class.map(|class| class.building_type.name())
    }

    /// Name of the place, or of the weather file.
    #[getter]
    fn place(&self) -> &str {
        &self.inner.place
    }

    /// The weather file (EPW).
    #[getter]
    fn weather(&self) -> PathBuf {
        self.inner.weather.clone()
    }

    /// Climate zone of ASHRAE 169, where it is known.
    #[getter]
    fn climate_zone(&self) -> Option<String> {
        self.inner.origin.climate_zone.clone()
    }

    /// What it was made of: the row of the dataset's table, as text; empty for a type or a model.
    #[getter]
    fn parameters(&self) -> BTreeMap<String, String> {
        self.inner.parameters.clone()
    }

    /// The model as the engine reads it (epJSON): sized and controllable once it was an environment.
    fn to_epjson(&self) -> String {
        match &*self.inner.source() {
            Source::Prepared(building) => building.model().to_epjson(),
            Source::Model { model, .. } => model.to_epjson(),
        }
    }

    fn __repr__(&self) -> String {
        format!("Building({:?}, place={:?})", self.inner.name, self.inner.place)
    }
}

/// What an episode is of: building, days, steps and task.
#[pyclass(frozen, module = "building2building._core")]
#[derive(Clone)]
pub struct Setting {
    /// For the crates.
    pub setting: vector::Setting,
    /// The building.
    pub building: Arc<Inner>,
}

#[pymethods]
impl Setting {
    #[new]
    fn new(building: &Building, run_period: &str, timesteps_per_hour: u32, task: &str) -> PyResult<Self> {
        let task = read_task(task)?;
        let period = run_period.parse().map_err(of_building)?;
        let weather = building.inner.weather.clone();
        let episode = EpisodeConfig { weather, period, steps_per_hour: timesteps_per_hour, task };
        let setting = vector::Setting { source: building.inner.source(), episode };
        Ok(Self { setting, building: Arc::clone(&building.inner) })
    }

    /// Steps of a whole episode.
    fn episode_steps(&self) -> u32 {
        self.setting.episode.period.days() * 24 * self.setting.episode.steps_per_hour
    }

    /// First day of the run period, counted from 1 on 1 January.
    fn first_day(&self) -> u32 {
        self.setting.episode.period.first().day_of_year()
    }

    /// The task as JSON.
    fn task(&self) -> String {
        serde_json::to_string(&self.setting.episode.task).expect("a task is plain data")
    }

    /// A random window of so many days, on one of a few first days; with how many steps it has.
    fn window(&self, days: u32, starts: u32, seed: u64) -> PyResult<(Self, usize)> {
        let mut windows = Windows { of: AnyOf(vec![self.setting.clone()]), days: (days, days), starts };
        let Draw { setting, steps } =
            windows.draw(0, &mut ChaCha8Rng::seed_from_u64(seed)).map_err(of_env)?;
        let steps = steps.unwrap_or(self.episode_steps() as usize);
        Ok((Self { setting, building: Arc::clone(&self.building) }, steps))
    }

    /// Cost (currency/m²) and emissions (g of CO₂/m²) of electricity and gas (Wh/m²) at an hour of the day.
    fn cost_and_emissions(&self, electricity: f64, gas: f64, hour: f64) -> (f64, f64) {
        self.setting.episode.task.cost_and_emissions([electricity, gas], hour)
    }
}

/// A task by its spelling, from a file, or from JSON.
pub fn read_task(text: &str) -> PyResult<Task> {
    if text.trim_start().starts_with('{') {
        let task: Task = serde_json::from_str(text)
            .map_err(|error| crate::error::raise("TaskError", format!("the task is no task: {error}")))?;
        task.check().map_err(of_env)?;
        return Ok(task);
    }
    let path = std::path::Path::new(text);
    let is_file = path.extension().is_some_and(|extension| extension == "json");
    if is_file { Task::read(path) } else { text.parse() }.map_err(of_env)
}

/// A building by its name: a type, an id, or a model file. The same names give the same object's data.
#[pyfunction]
#[pyo3(signature = (name, place=None, weather=None))]
pub fn find_building(
    py: Python<'_>,
    name: &str,
    place: Option<&str>,
    weather: Option<PathBuf>,
) -> PyResult<Building> {
    /// Buildings that were asked for last, by name and placement.
    static KNOWN: Mutex<Vec<(BuildingName, Placement, Arc<Inner>)>> = Mutex::new(Vec::new());
    const MOST: usize = 64;
    let name: BuildingName = name.parse().map_err(of_building)?;
    let place = place.map(Place::find).transpose().map_err(of_building)?;
    let placement = Placement { place, weather };
    let is_file = matches!(name, BuildingName::Model(_));
    let known = locked(&KNOWN)
        .iter()
        .find(|(known, at, _)| !is_file && (known, at) == (&name, &placement))
        .map(|(.., inner)| Arc::clone(inner));
    if let Some(inner) = known {
        return Ok(Building { inner });
    }
    let found = py.detach(|| catalog()?.find(&name, &placement, &mut Signals).map_err(of_building))?;
    let origin = placement.origin(&name);
    let (class, place, weather) = (found.class, found.place.clone(), found.weather.clone());
    let inner = Arc::new(Inner::new(found.into(), class, place, weather, origin).with_parameters(&name));
    let mut known = locked(&KNOWN);
    if known.len() == MOST {
        known.remove(0);
    }
    known.push((name, placement, Arc::clone(&inner)));
    Ok(Building { inner })
}

/// The first row of a table, without its empty cells.
fn cells(table: manifest::Manifest) -> BTreeMap<String, String> {
    let names = table.columns.iter().map(|column| column.name.to_owned());
    let row = table.rows.into_iter().next().unwrap_or_default();
    names.zip(row).filter(|(_, cell)| !cell.is_empty()).collect()
}

/// Buildings of a type drawn by a seed, as `b2b generate` does.
#[pyfunction]
#[pyo3(signature = (building_type, count, seed, places, weather, settings))]
pub fn generate(
    py: Python<'_>,
    building_type: &str,
    count: usize,
    seed: u64,
    places: Vec<String>,
    weather: Vec<PathBuf>,
    settings: Vec<String>,
) -> PyResult<Vec<Building>> {
    let building_type: BuildingType = building_type.parse().map_err(of_building)?;
    let settings =
        settings.iter().map(|text| text.parse()).collect::<Result<Vec<_>, _>>().map_err(of_building)?;
    let make = || -> PyResult<Vec<Building>> {
        let read = |path: &PathBuf| WeatherFile::read(path, None).map(Arc::new);
        let places = match (places.as_slice(), weather.as_slice()) {
            ([], []) => Places::All,
            (names, []) => Places::Named(names.to_vec()),
            (_, files) => {
                Places::Files(files.iter().map(read).collect::<Result<_, _>>().map_err(of_building)?)
            }
        };
        let buildings =
            b2b_dataset::sample(building_type, count, seed, &places, &settings).map_err(of_building)?;
        let catalog = catalog()?;
        let building = |(number, building): (usize, &b2b_dataset::Building)| {
            let (model, weather) = catalog.generate(building, &mut Signals).map_err(of_building)?;
            let name = format!("{building_type}-seed{seed}-{number:04}");
            let parameters = cells(manifest::of_buildings([(name.as_str(), building)]));
            let (place, origin) = (building.place().to_owned(), building.origin());
            let inner = Inner::new(
                Source::generated(name, building.class(), model),
                Some(building.class()),
                place,
                weather,
                origin,
            );
            let inner = Inner { parameters, ..inner };
            Ok(Building { inner: Arc::new(inner) })
        };
        (1..).zip(&buildings).map(building).collect()
    };
    py.detach(make)
}

/// The types with their homes and a line for people.
#[pyfunction]
pub fn building_types() -> Vec<(&'static str, &'static str, &'static str)> {
    BuildingType::ALL.map(|each| (each.name(), each.home(), each.description())).to_vec()
}

/// The known places with their climate zones.
#[pyfunction]
pub fn places() -> Vec<(&'static str, &'static str)> {
    b2b_climate::PLACES.iter().map(|place| (place.name, place.ashrae_zone)).collect()
}

/// The dataset's table of a type: names of the columns, and the rows as text.
#[pyfunction]
pub fn dataset_table(building_type: &str) -> PyResult<(Vec<&'static str>, Vec<Vec<String>>)> {
    let building_type: BuildingType = building_type.parse().map_err(of_building)?;
    let table = manifest::manifest(b2b_dataset::rows(building_type));
    Ok((table.columns.iter().map(|column| column.name).collect(), table.rows))
}
