//! From names on the command line to a building that is ready to run.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use b2b_building::climate::{Place, Site, epw};
use b2b_building::dataset::{self, BuildingId};
use b2b_building::{BuildingType, Model, PreparedBuilding, RunPeriod, commercial};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Cache, Engine, Progress};
use b2b_env::{Env, Episode, Task};

use crate::interrupt;
use crate::progress::{Download, spinner};

/// What a user calls a building.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BuildingName {
    /// A type: its base model.
    Type(BuildingType),
    /// A building of the dataset.
    Id(BuildingId),
}

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
    pub fn new(name: BuildingName, location: &Location, quiet: bool) -> Result<Self> {
        let mut download = Download::new(quiet);
        let (place, weather) = location.weather(name, &mut download)?;
        let engine = Engine::ensure(&mut download)?;
        let library = Library::load(&engine.library)?;
        interrupt::check()?;
        let spinner = spinner(format!("preparing {name} in {place}"), quiet);
        let site = Site::read(&weather)?;
        if let Some(note) = design_day_note(&site) {
            eprintln!("{place}: {note}");
        }
        let building = location
            .model(name, &engine, &library, &site)
            .and_then(|model| PreparedBuilding::new(&name.to_string(), model, &weather, &library));
        spinner.finish_and_clear();
        let building = Arc::new(building.with_context(|| format!("{name} cannot be prepared"))?);
        interrupt::check()?;
        Ok(Self { library, building, place, weather })
    }

    /// The building as an environment.
    pub fn env(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> Result<Env> {
        let episode = Episode { weather: self.weather.clone(), period, steps_per_hour, task };
        Ok(Env::new(self.library.clone(), Arc::clone(&self.building), episode)?)
    }
}

impl fmt::Display for BuildingName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Type(building_type) => building_type.fmt(f),
            Self::Id(id) => id.fmt(f),
        }
    }
}

impl FromStr for BuildingName {
    type Err = b2b_building::Error;

    /// Ids have a dash, and types have none.
    fn from_str(text: &str) -> b2b_building::Result<Self> {
        if text.contains('-') { text.parse().map(Self::Id) } else { text.parse().map(Self::Type) }
    }
}

impl Location {
    /// Name and weather file.
    fn weather(&self, name: BuildingName, progress: &mut dyn Progress) -> Result<(String, PathBuf)> {
        if let Some(path) = &self.weather {
            check_weather(path)?;
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            return Ok((name, path.clone()));
        }
        match (name, self.place) {
            (BuildingName::Id(id), None) => {
                let building = &dataset::row(id).building;
                Ok((building.place().to_owned(), building.weather(&Cache::from_env()?, progress)?))
            }
            (BuildingName::Id(id), Some(_)) => bail!(
                "{id} stands in {}: give --weather to put it under other weather, or a type for another place",
                dataset::row(id).building.place()
            ),
            (BuildingName::Type(building_type), place) => {
                let place = place.map_or_else(|| Place::find(building_type.home()), Ok)?;
                Ok((place.name.to_owned(), place.epw(progress)?))
            }
        }
    }

    /// The model before sizing: a base model at home stays as it is; elsewhere it is one for that climate.
    fn model(
        &self,
        name: BuildingName,
        engine: &Engine,
        library: &Library,
        site: &Site,
    ) -> b2b_building::Result<Model> {
        let building_type = match name {
            BuildingName::Type(building_type) => building_type,
            BuildingName::Id(id) => {
                return dataset::row(id)
                    .building
                    .model(&id.building_type().prototype(engine, library)?, site);
            }
        };
        let base = building_type.base_model(engine, library, site)?;
        match self.place {
            _ if building_type == BuildingType::SingleFamilyHouse => Ok(base),
            _ if self.weather.is_some() => commercial::relocated(&base, site),
            Some(place) if place.name != building_type.home() => {
                commercial::as_the_code_asks(&base, building_type, place, site)
            }
            _ => Ok(base),
        }
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

/// Names what is wrong with a weather file before the engine stumbles over it.
fn check_weather(path: &Path) -> Result<()> {
    let bytes = std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
    epw::check(&String::from_utf8_lossy(&bytes), path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_building_is_named_by_its_type_or_its_id() {
        let name = |text: &str| text.parse::<BuildingName>();
        assert_eq!(name("Warehouse").unwrap(), BuildingName::Type(BuildingType::Warehouse));
        assert_eq!(name("warehouse-7").unwrap().to_string(), "Warehouse-0007");
        assert!(name("Warehouse-1001").unwrap_err().to_string().contains("Warehouse-1000"));
        assert!(name("Warehose").unwrap_err().to_string().contains("Warehouse"));
    }
}
