//! From names on the command line to a building that is ready to run.

use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use b2b_building::climate::{Place, Site, epw};
use b2b_building::dataset::{self, BuildingId};
use b2b_building::description::Origin;
use b2b_building::{BuildingType, Model, PreparedBuilding, RunPeriod, commercial, import};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Cache, Engine, Progress};
use b2b_env::{Env, Episode, Task};

use crate::interrupt;
use crate::progress::{Download, spinner};

/// What a user calls a building.
#[derive(Clone, Debug, PartialEq)]
pub enum BuildingName {
    /// A type: its base model.
    Type(BuildingType),
    /// A building of the dataset.
    Id(BuildingId),
    /// A model of the user's own.
    Model(PathBuf),
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
    pub fn new(name: &BuildingName, location: &Location, quiet: bool) -> Result<Self> {
        let mut download = Download::new(quiet);
        let (place, weather) = location.weather(name, &mut download)?;
        let engine = Engine::ensure(&mut download)?;
        let library = Library::load(&engine.library)?;
        interrupt::check()?;
        let spinner = spinner(format!("preparing {name} in {place}"), quiet);
        let site = Site::read(&weather)?;
        let make = match name {
            BuildingName::Model(_) => PreparedBuilding::as_far_as_possible,
            _ => PreparedBuilding::new,
        };
        if let Some(note) = design_day_note(&site) {
            eprintln!("{place}: {note}");
        }
        let building = location
            .model(name, &engine, &library, &site)
            .and_then(|model| make(&name.to_string(), model, &weather, &library));
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
    pub fn episode(&self, period: RunPeriod, steps_per_hour: u32, task: Task) -> Episode {
        Episode { weather: self.weather.clone(), period, steps_per_hour, task }
    }
}

impl fmt::Display for BuildingName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Type(building_type) => building_type.fmt(f),
            Self::Id(id) => id.fmt(f),
            Self::Model(path) => f.write_str(&path.file_stem().unwrap_or_default().to_string_lossy()),
        }
    }
}

impl FromStr for BuildingName {
    type Err = b2b_building::Error;

    /// Model files have their ending or a folder, ids have a dash, and types have none.
    fn from_str(text: &str) -> b2b_building::Result<Self> {
        let path = Path::new(text);
        if import::is_model_file(path) || text.contains(std::path::is_separator) {
            return Ok(Self::Model(path.to_owned()));
        }
        if text.contains('-') { text.parse().map(Self::Id) } else { text.parse().map(Self::Type) }
    }
}

impl Location {
    /// As arguments on the command line.
    pub fn arguments(&self) -> Vec<OsString> {
        let place = self.place.map(|place| ["--place".into(), place.name.into()]);
        let weather = self.weather.as_ref().map(|path| ["--weather".into(), path.clone().into_os_string()]);
        place.into_iter().chain(weather).flatten().collect()
    }

    /// Name and weather file.
    fn weather(&self, name: &BuildingName, progress: &mut dyn Progress) -> Result<(String, PathBuf)> {
        if let Some(path) = &self.weather {
            check_weather(path)?;
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            return Ok((name, path.clone()));
        }
        match (name, self.place) {
            (BuildingName::Id(id), None) => {
                let building = &dataset::row(*id).building;
                Ok((building.place().to_owned(), building.weather(&Cache::from_env()?, progress)?))
            }
            (BuildingName::Id(id), Some(_)) => bail!(
                "{id} stands in {}: give --weather to put it under other weather, or a type for another place",
                dataset::row(*id).building.place()
            ),
            (BuildingName::Type(building_type), place) => {
                let place = place.map_or_else(|| Place::find(building_type.home()), Ok)?;
                Ok((place.name.to_owned(), place.epw(progress)?))
            }
            (BuildingName::Model(_), Some(place)) => Ok((place.name.to_owned(), place.epw(progress)?)),
            (BuildingName::Model(path), None) => bail!(
                "{} has no weather: give --weather FILE.epw, or --place NAME (`b2b list places`)",
                path.display()
            ),
        }
    }

    /// What is known of the building beside its model.
    pub fn origin(&self, name: &BuildingName) -> Origin {
        match name {
            BuildingName::Id(id) => Origin::of(&dataset::row(*id).building),
            BuildingName::Model(_) | BuildingName::Type(BuildingType::SingleFamilyHouse) => Origin::default(),
            BuildingName::Type(_) if self.weather.is_some() => Origin::commercial(None),
            BuildingName::Type(building_type) => {
                let home = || Place::find(building_type.home()).ok();
                Origin::commercial(self.place.or_else(home).map(|place| place.ashrae_zone))
            }
        }
    }

    /// The model before sizing: a base model at home stays as it is; elsewhere it is one for that climate.
    fn model(
        &self,
        name: &BuildingName,
        engine: &Engine,
        library: &Library,
        site: &Site,
    ) -> b2b_building::Result<Model> {
        let building_type = match name {
            BuildingName::Type(building_type) => *building_type,
            BuildingName::Id(id) => {
                let prototype = id.building_type().prototype(engine, library)?;
                return dataset::row(*id).building.model(&prototype, site);
            }
            BuildingName::Model(path) => return import::read(path, library),
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
        assert_eq!(name("my-office.IDF").unwrap(), BuildingName::Model("my-office.IDF".into()));
        assert_eq!(name("models/office").unwrap(), BuildingName::Model("models/office".into()));
        assert!(name("Warehouse-1001").unwrap_err().to_string().contains("Warehouse-1000"));
        assert!(name("Warehose").unwrap_err().to_string().contains("Warehouse"));
    }
}
