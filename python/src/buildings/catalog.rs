//! Buildings: found by name, generated, or imported by the user.

use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use b2b_building::description::Origin;
use b2b_building::{BuildingType, Class, Model, Period, RunPeriod};
use b2b_climate::{EpwFile, Hour, Place, WeatherFile};
use b2b_dataset::{BuildingName, Catalog, Control, Placement, manifest};
use b2b_energyplus::install::use_packages_in;
use b2b_env::{EpisodeConfig, Task};
use b2b_evaluate::{SiteInfo, Subject};
use b2b_workers::{AnyOf, Draw, Jobs, Sampler, Source, Windows, WorkerOptions};
use numpy::PyArray1;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::buildings::table::{self, Row};
use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_building, of_env, of_task};
use crate::interpreter::process::{launcher, locked};
use crate::interpreter::signals::{Signals, interrupted, stopped};

/// Returns the catalog with the engine and its models, loaded on first use.
pub fn catalog() -> PyResult<Arc<Catalog>> {
    static CATALOG: Mutex<Option<Arc<Catalog>>> = Mutex::new(None);
    let mut known = locked(&CATALOG);
    if let Some(catalog) = &*known {
        return Ok(Arc::clone(catalog));
    }
    if let Some(folder) = site_packages()? {
        use_packages_in(folder);
    }
    let catalog = Catalog::open(&mut Signals).map_err(of_building)?;
    let catalog = match Python::attach(launcher) {
        Ok(launcher) => {
            let options = WorkerOptions::new(launcher, catalog.library().path());
            catalog.hosted_by(Arc::new(Jobs::new(WorkerOptions {
                interrupted: stopped_or_interrupted,
                ..options
            })))
        }
        // An embedded interpreter cannot be started again, so it reads models in this process.
        Err(_) => catalog,
    };
    Ok(Arc::clone(known.insert(Arc::new(catalog))))
}

/// Returns whether an evaluation must stop or, in the main thread, a signal handler raised an exception.
fn stopped_or_interrupted() -> bool {
    stopped() || interrupted()
}

/// Returns the folder where pip installed the engine.
fn site_packages() -> PyResult<Option<PathBuf>> {
    Python::attach(|py| py.import("building2building.process.engine")?.call_method0("folder")?.extract())
}

/// Returns the path of the engine's library.
pub fn library() -> PyResult<PathBuf> {
    Ok(catalog()?.library().path().to_owned())
}

/// Memory limit for the idle templates of one environment, bytes.
pub const TEMPLATES: u64 = 1 << 30;

/// Returns the options of workers that run this interpreter.
pub fn worker_options(py: Python<'_>) -> PyResult<WorkerOptions> {
    let launcher = launcher(py)?;
    let library = py.detach(library)?;
    Ok(WorkerOptions { interrupted, template_memory: TEMPLATES, ..WorkerOptions::new(launcher, library) })
}

/// A building with its weather file.
#[pyclass(frozen, module = "building2building._core")]
pub struct Building {
    /// The data that all environments of the building share.
    pub inner: Arc<Inner>,
}

/// The data of a building that all its environments share.
pub struct Inner {
    name: String,
    class: Option<Class>,
    place: String,
    weather: PathBuf,
    pub origin: Origin,
    parameters: Row,
    source: Mutex<Arc<Source>>,
}

impl Inner {
    /// Creates a building of an evaluation from its prepared model.
    pub fn of_subject(subject: &Subject, site: &SiteInfo, spaces: &b2b_env::Spaces) -> Self {
        let source = Source::Prepared(Box::new((*spaces.building).clone()));
        let (place, weather) = (site.place.clone(), spaces.episode.weather.clone());
        let origin = subject.placement.origin(&subject.name);
        Self::new(source, spaces.building.class, place, weather, origin).with_parameters(&subject.name)
    }

    /// Creates a building of the generator.
    pub fn of_generated(
        name: String,
        building: &b2b_dataset::Building,
        model: Model,
        weather: PathBuf,
    ) -> Self {
        let parameters = first_row(manifest::of_buildings([(name.as_str(), building)]));
        let (class, place, origin) = (building.class(), building.place().to_owned(), building.origin());
        let source = Source::generated(name, class, model, weather.clone());
        let inner = Self::new(source, Some(class), place, weather, origin);
        Self { parameters, ..inner }
    }

    /// Adds its row of the dataset's table.
    fn with_parameters(mut self, name: &BuildingName) -> Self {
        if let BuildingName::Id(id) = name {
            self.parameters = first_row(manifest::manifest([b2b_dataset::row(*id)]));
        }
        self
    }

    /// Creates a building; `class` is `None` for an imported model.
    fn new(source: Source, class: Option<Class>, place: String, weather: PathBuf, origin: Origin) -> Self {
        let name = source.name().to_owned();
        let source = Mutex::new(Arc::new(source));
        Self { name, class, place, weather, origin, parameters: Row::new(), source }
    }

    /// Returns the model, prepared or not.
    pub fn source(&self) -> Arc<Source> {
        Arc::clone(&locked(&self.source))
    }

    /// Returns the weather file.
    pub fn weather(&self) -> &Path {
        &self.weather
    }

    /// Returns the name of the place, or of the weather file.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// Returns the building type; `None` for an imported model.
    pub fn building_type(&self) -> Option<&'static str> {
        self.class.map(|class| class.building_type.name())
    }

    /// Creates a building from its spaces.
    pub fn of_spaces(spaces: &b2b_env::Spaces) -> Self {
        let source = Source::Prepared(Box::new((*spaces.building).clone()));
        let (class, weather) = (spaces.building.class, spaces.episode.weather.clone());
        let Ok(name @ BuildingName::Id(id)) = Control::split_name(&spaces.building.name).0.parse() else {
            let place = weather.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            return Self::new(source, class, place, weather, Origin::default());
        };
        let building = &b2b_dataset::row(id).building;
        let (place, origin) = (building.place().to_owned(), building.origin());
        Self::new(source, class, place, weather, origin).with_parameters(&name)
    }

    /// Keeps the prepared model, so that other environments do not prepare it again.
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

    /// Building type; `None` for an imported model.
    #[getter]
    fn building_type(&self) -> Option<&'static str> {
        self.inner.building_type()
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

    /// ASHRAE 169 climate zone, if known.
    #[getter]
    fn climate_zone(&self) -> Option<String> {
        self.inner.origin.climate_zone.clone()
    }

    /// Its row of the dataset's table; empty for a prototype or an imported model.
    #[getter]
    fn parameters(&self) -> Row {
        self.inner.parameters.clone()
    }

    /// Returns the model as epJSON text; sized and controllable once an environment of it was created.
    fn to_epjson(&self) -> String {
        let mut model = match &*self.inner.source() {
            Source::Prepared(building) => building.model().clone(),
            Source::Model { model, .. } => (**model).clone(),
        };
        model.name_house(&self.inner.name);
        model.to_epjson()
    }

    fn __repr__(&self) -> String {
        format!("Building({:?}, place={:?})", self.inner.name, self.inner.place)
    }
}

/// A quantity of an hour of weather.
type OfHour = fn(&Hour) -> f64;

/// The quantities of a weather file by their names.
static WEATHER: [(&str, OfHour); 6] = [
    ("temperature", |hour| hour.dry_bulb),
    ("dew_point", |hour| hour.dew_point),
    ("humidity", |hour| hour.relative_humidity),
    ("direct_radiation", |hour| hour.direct_radiation),
    ("diffuse_radiation", |hour| hour.diffuse_radiation),
    ("wind_speed", |hour| hour.wind_speed),
];

/// The building, run period, time step and task of an episode.
#[pyclass(frozen, module = "building2building._core")]
#[derive(Clone)]
pub struct Setting {
    /// The underlying setting.
    pub setting: b2b_workers::EpisodeSetting,
    /// The building.
    pub building: Arc<Inner>,
}

#[pymethods]
impl Setting {
    #[new]
    fn new(building: &Building, run_period: &str, timesteps_per_hour: u32, task: &str) -> PyResult<Self> {
        let task = read_task(task)?;
        let weather = building.inner.weather.clone();
        let period: Period = run_period.parse().map_err(of_building)?;
        let period = period.in_weather(&weather).map_err(of_building)?;
        let episode = EpisodeConfig { weather, period, steps_per_hour: timesteps_per_hour, task };
        let setting = b2b_workers::EpisodeSetting { source: building.inner.source(), episode };
        Ok(Self { setting, building: Arc::clone(&building.inner) })
    }

    /// Number of steps of a whole episode.
    #[getter]
    fn episode_steps(&self) -> u32 {
        self.period().days() * 24 * self.setting.episode.steps_per_hour
    }

    /// First day of the run period as day of a year without 29 February, from 1.
    #[getter]
    fn first_day(&self) -> u32 {
        self.setting.episode.period.first().day_of_year()
    }

    /// First hour of the run period as hour of the building's year, from 0.
    #[getter]
    fn first_hour(&self) -> u32 {
        24 * (self.period().day_of_year(0) - 1)
    }

    /// Number of days of the building's year.
    #[getter]
    fn days_of_year(&self) -> u32 {
        self.period().calendar().days()
    }

    /// Returns month and day of the month of a day of the run period, from 0.
    fn date(&self, day: u32) -> [u32; 2] {
        self.period().date(day).month_and_day()
    }

    /// Returns the values of a quantity of the weather file for each hour of the building's year.
    fn hourly_weather<'py>(&self, py: Python<'py>, quantity: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = WEATHER.iter().find(|(name, _)| *name == quantity);
        let (_, value) = found.ok_or_else(|| {
            let known = WEATHER.map(|(name, _)| name).join(", ");
            let message = format!("unknown weather quantity `{quantity}`; expected one of {known}");
            Exception::Setting.new_err(message)
        })?;
        let file = EpwFile::open(&self.setting.episode.weather).map_err(of_building)?;
        let record = file.record().map_err(of_building)?;
        Ok(arrays::row(py, &record.by_date(self.period().calendar(), value)))
    }

    /// Returns the task's definition as JSON text.
    fn task_json(&self) -> String {
        serde_json::to_string(&self.setting.episode.task).expect("a task is plain data")
    }

    /// Name of the task's baseline controller.
    #[getter]
    fn baseline(&self) -> &'static str {
        b2b_control::baseline(&self.setting.episode.task).name()
    }

    /// Path of the weather file.
    #[getter]
    fn weather(&self) -> &Path {
        &self.setting.episode.weather
    }

    /// Returns the setting with another weather file. Equipment stays sized for the building's own.
    fn with_weather(&self, file: PathBuf) -> Self {
        let mut setting = self.setting.clone();
        setting.episode.weather = file;
        Self { setting, building: Arc::clone(&self.building) }
    }

    /// Draws a window of `days` days that begins on one of `starts` days; returns it with its number of steps.
    fn window(&self, days: u32, starts: u32, seed: u64) -> PyResult<(Self, usize)> {
        let mut windows = Windows { of: AnyOf(vec![self.setting.clone()]), days: (days, days), starts };
        let Draw { setting, steps } =
            windows.draw(0, &mut ChaCha8Rng::seed_from_u64(seed)).map_err(of_env)?;
        let steps = steps.unwrap_or(self.episode_steps() as usize);
        Ok((Self { setting, building: Arc::clone(&self.building) }, steps))
    }
}

impl Setting {
    /// Returns the run period, in the building's calendar once its model is prepared.
    fn period(&self) -> RunPeriod {
        let period = self.setting.episode.period;
        match &*self.building.source() {
            Source::Prepared(building) => building.in_its_calendar(period),
            Source::Model { .. } => period,
        }
    }
}

/// Raises an error unless a file is a weather file of a whole year.
#[pyfunction]
pub fn check_weather(file: PathBuf) -> PyResult<()> {
    WeatherFile::read(&file, None).map(drop).map_err(|error| of_building(b2b_dataset::Error::from(error)))
}

/// Reads a task from its short form, a JSON file or JSON text.
pub fn read_task(text: &str) -> PyResult<Task> {
    Task::from_text(text).map_err(of_task)
}

/// Reads what an agent sets in a building; `actuators` by default.
pub fn read_control(control: Option<&str>) -> PyResult<Control> {
    Ok(control.map(str::parse).transpose().map_err(of_building)?.unwrap_or_default())
}

/// Finds a building by its name: a type, a dataset id or a model file. Except for files of models and weather, which may
/// change, recent results with the same name and placement share their data.
#[pyfunction]
#[pyo3(signature = (name, place=None, weather=None, allow_external=false, control=None, keep_design_days=false))]
pub fn find_building(
    py: Python<'_>,
    name: &str,
    place: Option<&str>,
    weather: Option<PathBuf>,
    allow_external: bool,
    control: Option<&str>,
    keep_design_days: bool,
) -> PyResult<Building> {
    /// The most recently found buildings, by name and placement.
    static KNOWN: Mutex<Vec<(BuildingName, Placement, Arc<Inner>)>> = Mutex::new(Vec::new());
    const MAX_KNOWN: usize = 64;
    let name: BuildingName = name.parse().map_err(of_building)?;
    let place = place.map(Place::find).transpose().map_err(of_building)?;
    let control = read_control(control)?;
    let placement = Placement { place, weather, allow_external, control, keep_design_days, transition: None };
    let is_file = matches!(name, BuildingName::Model(_)) || placement.weather.is_some();
    let known = locked(&KNOWN)
        .iter()
        .find(|(known, at, _)| !is_file && (known, at) == (&name, &placement))
        .map(|(.., inner)| Arc::clone(inner));
    if let Some(inner) = known {
        return Ok(Building { inner });
    }
    let found = py.detach(|| catalog()?.find(&name, &placement, &mut Signals).map_err(of_building))?;
    for note in found.notes.lines() {
        let text = CString::new(format!("{name}: {note}")).unwrap_or_default();
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 2)?;
    }
    let origin = placement.origin(&name);
    let (class, place, weather) = (found.class, found.place.clone(), found.weather.clone());
    let inner = Arc::new(Inner::new(found.into(), class, place, weather, origin).with_parameters(&name));
    let mut known = locked(&KNOWN);
    if known.len() == MAX_KNOWN {
        known.remove(0);
    }
    known.push((name, placement, Arc::clone(&inner)));
    Ok(Building { inner })
}

fn first_row(table: manifest::Manifest) -> Row {
    table::rows(table).into_iter().next().unwrap_or_default()
}

/// A building type.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct TypeInfo {
    /// Name, for example `OfficeSmall`.
    name: &'static str,
    /// Name of its default place.
    default_place: &'static str,
    /// Description in one line.
    description: &'static str,
}

/// Returns the building types.
#[pyfunction]
pub fn building_types() -> Vec<TypeInfo> {
    let info = |each: BuildingType| TypeInfo {
        name: each.name(),
        default_place: each.home(),
        description: each.description(),
    };
    BuildingType::ALL.map(info).into()
}

/// Returns the known places: name and ASHRAE 169 climate zone.
#[pyfunction]
pub fn places() -> Vec<(&'static str, &'static str)> {
    b2b_climate::PLACES.iter().map(|place| (place.name, place.ashrae_zone)).collect()
}

/// Returns the dataset's table for a type, one dictionary per building.
#[pyfunction]
pub fn dataset_rows(building_type: &str) -> PyResult<Vec<Row>> {
    let building_type: BuildingType = building_type.parse().map_err(of_building)?;
    Ok(table::rows(manifest::manifest(b2b_dataset::rows(building_type))))
}
