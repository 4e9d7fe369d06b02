//! Preparation of a building, from its name to a model that is ready to run.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use b2b_building::{Controls, PreparedBuilding, RunPeriod};
use b2b_dataset::{BuildingName, Catalog};
use b2b_energyplus::Library;
use b2b_env::{Env, EpisodeConfig, Spaces, Task};
use b2b_workers::{Autoreset, EpisodeSetting, Source, VecEnvOptions, WorkerOptions};

use crate::arguments::location::Location;
use crate::program::{self, weather};
use crate::terminal::interrupt;
use crate::terminal::progress::{Download, spinner};

/// A prepared building with its place and engine.
pub struct Prepared {
    /// The engine.
    pub library: Library,
    /// The building.
    pub building: Arc<PreparedBuilding>,
    /// Name of the place, or of the weather file.
    pub place: String,
    /// The weather file.
    pub weather: PathBuf,
}

impl Prepared {
    /// Downloads missing files and prepares a building. Shows progress unless `quiet`.
    pub fn new(name: &BuildingName, location: &Location, quiet: bool) -> Result<Self> {
        Self::under(Controls::default(), name, location, quiet)
    }

    /// Like [`Prepared::new`], under these controls.
    pub fn under(controls: Controls, name: &BuildingName, location: &Location, quiet: bool) -> Result<Self> {
        Self::find(&program::catalog(&mut Download::new(quiet))?, controls, name, location, quiet)
    }

    /// Like [`Prepared::new`], with a shared catalog.
    pub fn of(catalog: &Catalog, name: &BuildingName, location: &Location, quiet: bool) -> Result<Self> {
        Self::find(catalog, Controls::default(), name, location, quiet)
    }

    fn find(
        catalog: &Catalog,
        controls: Controls,
        name: &BuildingName,
        location: &Location,
        quiet: bool,
    ) -> Result<Self> {
        let found = catalog.find(name, &location.placement(), &mut Download::new(quiet));
        interrupt::check()?;
        let found = found.with_context(|| format!("cannot prepare {name}"))?;
        let (place, weather) = (found.place.clone(), found.weather.clone());
        let keeps_own = location.placement().keep_design_days && matches!(name, BuildingName::Model(_));
        let of_design_days = weather::design_day_note(&found.site).filter(|_| !keeps_own);
        for note in of_design_days.into_iter().chain(weather::part_of_year_note(&weather)?) {
            eprintln!("{place}: {note}");
        }
        for note in found.notes.lines() {
            eprintln!("{name}: {note}");
        }
        interrupt::check()?;
        let spinner = spinner(format!("preparing {name} in {place}"), quiet);
        let library = catalog.library().clone();
        let building = found.under(controls).prepare(&library);
        spinner.finish_and_clear();
        interrupt::check()?;
        let building = Arc::new(building.with_context(|| format!("cannot prepare {name}"))?);
        interrupt::check()?;
        Ok(Self { library, building, place, weather })
    }

    /// Returns an environment of the building.
    pub fn env(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> Result<Env> {
        let episode = self.episode(period, steps_per_hour, task);
        Ok(Env::new(self.library.clone(), Arc::clone(&self.building), episode)?)
    }

    /// Returns the spaces of an episode of the building.
    pub fn spaces(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> Result<Spaces> {
        let episode = self.episode(period, steps_per_hour, task);
        episode.check()?;
        Ok(Spaces::new(Arc::clone(&self.building), episode))
    }

    /// Returns the configuration of an episode with the building's weather.
    pub fn episode(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> EpisodeConfig {
        EpisodeConfig { weather: self.weather.clone(), period, steps_per_hour, task }
    }
}

/// For worker processes.
impl Prepared {
    /// Returns the options of workers with this building's engine.
    pub fn worker_options(&self) -> WorkerOptions {
        program::worker_options(self.library.path())
    }

    /// Returns the options of a batch of environments.
    pub fn vec_env_options(&self) -> VecEnvOptions {
        VecEnvOptions { workers: self.worker_options(), autoreset: Autoreset::NextStep, widths: None }
    }

    /// Returns the setting of an episode in this building.
    pub fn setting(&self, episode: EpisodeConfig) -> EpisodeSetting {
        EpisodeSetting::new(Source::Prepared(Box::new((*self.building).clone())), episode)
    }
}
