//! From the name of a building to its environment.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use b2b_building::{PreparedBuilding, RunPeriod};
use b2b_climate::Place;
use b2b_dataset::{BuildingName, Catalog, Control, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{Env, EpisodeConfig, Task};
use b2b_workers::{
    Autoreset, Episode, EpisodeSetting, Fixed, Jobs, Launcher, Source, VecEnv, VecEnvOptions, WorkerOptions,
    Workers,
};

use crate::{Error, Result};

/// Default number of zone time steps per hour: a step is five minutes.
const STEPS_PER_HOUR: u32 = 12;

/// Names a building: a type (`OfficeSmall`), a building of the dataset (`OfficeSmall-0042`) or a model file (`my.idf`).
///
/// # Errors
/// [`Error::Dataset`] for an unknown type or id. A model file is first read when an environment is built.
pub fn make(name: &str) -> Result<EnvBuilder> {
    Ok(EnvBuilder {
        name: name.parse()?,
        placement: Placement::default(),
        task: Task::default(),
        period: RunPeriod::WINTER,
        steps_per_hour: STEPS_PER_HOUR,
        error: None,
    })
}

/// Builds environments of one building. Invalid settings are reported when it builds.
#[derive(Debug)]
pub struct EnvBuilder {
    name: BuildingName,
    placement: Placement,
    task: Task,
    period: RunPeriod,
    steps_per_hour: u32,
    /// The first error in its settings.
    error: Option<Error>,
}

impl EnvBuilder {
    /// Sets the task by its name, as on the command line: `constant`, `occupancy`, `occupancy+energy0.5`...
    #[must_use]
    pub fn task(self, name: &str) -> Self {
        self.set(name.parse::<Task>().map_err(Error::from), |builder, task| builder.task = task)
    }

    /// Sets the task: setpoints, comfort and reward.
    #[must_use]
    pub fn with_task(mut self, task: Task) -> Self {
        self.task = task;
        self
    }

    /// Sets the days of an episode: `winter` (the default), `summer`, `full_year` or `MM-DD..MM-DD`.
    #[must_use]
    pub fn period(self, period: &str) -> Self {
        self.set(period.parse::<RunPeriod>().map_err(Error::from), |builder, period| {
            builder.period = period;
        })
    }

    /// Moves the building to a known place, such as `Denver`. Buildings of the dataset have their own.
    #[must_use]
    pub fn place(self, name: &str) -> Self {
        self.set(Place::find(name).map_err(Error::from), |builder, place| {
            builder.placement.place = Some(place)
        })
    }

    /// Controls every zone through the heating and the cooling setpoint of its thermostat, which the building's
    /// equipment follows.
    #[must_use]
    pub fn setpoints(mut self) -> Self {
        self.placement.control = Control::Setpoints;
        self
    }

    /// Lets the user's model run code and open files outside its folder.
    #[must_use]
    pub fn allow_external(mut self) -> Self {
        self.placement.allow_external = true;
        self
    }

    /// Sets the weather file (EPW). It takes precedence over a place.
    #[must_use]
    pub fn weather(mut self, file: impl Into<PathBuf>) -> Self {
        self.placement.weather = Some(file.into());
        self
    }

    /// Sets the steps per hour: 12 unless set; a divisor of 60.
    #[must_use]
    pub fn steps_per_hour(mut self, steps: u32) -> Self {
        self.steps_per_hour = steps;
        self
    }

    /// Builds an environment that runs the engine in this process, where one can run at a time.
    ///
    /// # Errors
    /// [`Error::Environment`] for an unknown task, [`Error::Building`] for an unknown period, [`Error::Climate`] for an
    /// unknown place; errors from finding, sizing and preparing the building, and from [`Env::new`].
    pub fn build(self) -> Result<Env> {
        let catalog = catalog()?;
        let (building, episode) = self.prepare(&catalog)?;
        Ok(Env::new(catalog.library().clone(), Arc::new(building), episode)?)
    }

    /// Builds an environment that runs the engine in its own worker process: a crash loses one episode, a reset takes
    /// milliseconds, and an episode has snapshots and branches. Workers start this program again, so call
    /// [`run_if_worker`](crate::run_if_worker) first in `main`.
    ///
    /// # Errors
    /// The errors of [`EnvBuilder::build`] and [`Workers::episode`].
    pub fn build_in_worker(self) -> Result<Episode> {
        let (setting, options) = self.setting()?;
        Ok(Workers::new(options)?.episode(&setting)?)
    }

    /// Builds a batch of `count` environments, each in a worker process: see [`EnvBuilder::build_in_worker`].
    ///
    /// # Errors
    /// The errors of [`EnvBuilder::build`] and [`VecEnv::new`].
    pub fn build_batch(self, count: usize) -> Result<VecEnv> {
        let (setting, workers) = self.setting()?;
        let options = VecEnvOptions { workers, autoreset: Autoreset::NextStep, widths: None };
        Ok(VecEnv::new(count, Box::new(Fixed(vec![setting; count])), options)?)
    }

    /// Returns the building and its episode as a setting for worker processes, with the options to start them, for
    /// episodes that share workers and for samplers.
    ///
    /// # Errors
    /// The errors of [`EnvBuilder::build`].
    pub fn setting(self) -> Result<(EpisodeSetting, WorkerOptions)> {
        let catalog = hosted_catalog()?;
        let (building, episode) = self.prepare(&catalog)?;
        let options = WorkerOptions::new(Launcher::this_program()?, catalog.library().path());
        Ok((EpisodeSetting::new(Source::Prepared(Box::new(building)), episode), options))
    }

    fn set<T>(mut self, value: Result<T>, put: impl FnOnce(&mut Self, T)) -> Self {
        match value {
            Ok(value) => put(&mut self, value),
            Err(error) => self.error = self.error.or(Some(error)),
        }
        self
    }

    /// Downloads missing files, sizes the building and makes it controllable.
    fn prepare(self, catalog: &Catalog) -> Result<(PreparedBuilding, EpisodeConfig)> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let found = catalog.find(&self.name, &self.placement, &mut Quiet)?;
        let weather = found.weather.clone();
        let building = found.prepare(catalog.library())?;
        let (period, steps_per_hour) = (self.period, self.steps_per_hour);
        Ok((building, EpisodeConfig { weather, period, steps_per_hour, task: self.task }))
    }
}

/// The engine and the prototypes, opened once per process.
type Shared = Mutex<Option<Arc<Catalog>>>;

/// Returns the catalog for models in this process.
fn catalog() -> Result<Arc<Catalog>> {
    static CATALOG: Shared = Mutex::new(None);
    shared(&CATALOG, || Ok(Catalog::open(&mut Quiet)?))
}

/// Returns the catalog for models in worker processes, where they are also read and sized.
pub(crate) fn hosted_catalog() -> Result<Arc<Catalog>> {
    static CATALOG: Shared = Mutex::new(None);
    shared(&CATALOG, || {
        let catalog = Catalog::open(&mut Quiet)?;
        let options = WorkerOptions::new(Launcher::this_program()?, catalog.library().path());
        Ok(catalog.hosted_by(Arc::new(Jobs::new(options))))
    })
}

fn shared(kept: &Shared, open: impl FnOnce() -> Result<Catalog>) -> Result<Arc<Catalog>> {
    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(catalog) = &*kept {
        return Ok(Arc::clone(catalog));
    }
    let opened = Arc::new(open()?);
    *kept = Some(Arc::clone(&opened));
    Ok(opened)
}
