//! From names on the command line to a building that is ready to run.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result};
use b2b_building::climate::{Place, Site, epw};
use b2b_building::{BuildingType, PreparedBuilding, RunPeriod};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Progress};
use b2b_env::{Env, Episode, Task};

use crate::interrupt;
use crate::progress::{Download, spinner};

/// Where the building stands.
#[derive(clap::Args, Default)]
pub struct Location {
    /// Place whose weather and climate the building gets (`b2b list places`); the type's home by default
    #[arg(long, value_name = "NAME", value_parser = Place::find, conflicts_with = "weather")]
    place: Option<&'static Place>,
    /// Weather file to use instead of a known place
    #[arg(long, value_name = "FILE.epw")]
    weather: Option<PathBuf>,
}

/// A building at a place, with the engine to run it.
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
    /// Sets up what is missing and prepares a building of a type. Shows progress unless `quiet`.
    pub fn new(building_type: BuildingType, location: &Location, quiet: bool) -> Result<Self> {
        let mut download = Download::new(quiet);
        let (place, weather) = location.weather(building_type, &mut download)?;
        let engine = Engine::ensure(&mut download)?;
        let library = Library::load(&engine.library)?;
        interrupt::check()?;
        let spinner = spinner(format!("preparing {building_type} in {place}"), quiet);
        let model = building_type.base_model(&engine, &library, &Site::read(&weather)?)?;
        let building = PreparedBuilding::new(building_type.name(), model, &weather, &library);
        spinner.finish_and_clear();
        let building = Arc::new(building.with_context(|| format!("{building_type} cannot be prepared"))?);
        interrupt::check()?;
        Ok(Self { library, building, place, weather })
    }

    /// The building as an environment.
    pub fn env(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> Result<Env> {
        let episode = Episode { weather: self.weather.clone(), period, steps_per_hour, task };
        Ok(Env::new(self.library.clone(), Arc::clone(&self.building), episode)?)
    }
}

impl Location {
    /// Name and weather file.
    fn weather(&self, building_type: BuildingType, progress: &mut dyn Progress) -> Result<(String, PathBuf)> {
        if let Some(path) = &self.weather {
            check_weather(path)?;
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            return Ok((name, path.clone()));
        }
        let place = match self.place {
            Some(place) => place,
            None => Place::find(building_type.home())?,
        };
        Ok((place.name.to_owned(), place.epw(progress)?))
    }
}

/// Names what is wrong with a weather file before the engine stumbles over it.
fn check_weather(path: &Path) -> Result<()> {
    let bytes = std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
    epw::check(&String::from_utf8_lossy(&bytes), path)?;
    Ok(())
}
