//! From names on the command line to a building that is ready to run.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use b2b_building::{PreparedBuilding, RunPeriod};
use b2b_climate::{Place, Site};
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_energyplus::Library;
use b2b_env::{Env, EpisodeConfig, Task};

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
    /// Sets up what is missing and prepares a building. Shows progress unless `quiet`.
    pub fn new(name: &BuildingName, location: &Location, quiet: bool) -> Result<Self> {
        let mut download = Download::new(quiet);
        let catalog = Catalog::open(&mut download)?;
        let found = catalog.find(name, &location.placement(), &mut download);
        let found = found.with_context(|| format!("{name} cannot be prepared"))?;
        let (place, weather) = (found.place.clone(), found.weather.clone());
        if let Some(note) = design_day_note(&found.site) {
            eprintln!("{place}: {note}");
        }
        interrupt::check()?;
        let spinner = spinner(format!("preparing {name} in {place}"), quiet);
        let library = catalog.library().clone();
        let building = found.prepare(&library);
        spinner.finish_and_clear();
        let building = Arc::new(building.with_context(|| format!("{name} cannot be prepared"))?);
        interrupt::check()?;
        Ok(Self { library, building, place, weather })
    }

    /// The building as an environment.
    pub fn env(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> Result<Env> {
        let episode = self.episode(period, steps_per_hour, task);
        Ok(Env::new(self.library.clone(), Arc::clone(&self.building), episode)?)
    }

    /// What an episode is made of, under this weather.
    pub fn episode(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> EpisodeConfig {
        EpisodeConfig { weather: self.weather.clone(), period, steps_per_hour, task }
    }
}

impl Location {
    /// As arguments on the command line.
    pub fn arguments(&self) -> Vec<OsString> {
        let place = self.place.map(|place| ["--place".into(), place.name.into()]);
        let weather = self.weather.as_ref().map(|path| ["--weather".into(), path.clone().into_os_string()]);
        place.into_iter().chain(weather).flatten().collect()
    }

    /// The same for the catalog.
    pub fn placement(&self) -> Placement {
        Placement { place: self.place, weather: self.weather.clone() }
    }
}

/// What the user should know of the weather that equipment is sized for.
pub fn design_day_note(site: &Site) -> Option<String> {
    site.sized_by_hours.then(|| {
        format!(
            "the file has no design conditions: equipment is sized for the 99.6 % and 0.4 % of its own hours, {:.1} and \
             {:.1} °C",
            site.heating.dry_bulb, site.cooling.dry_bulb
        )
    })
}
