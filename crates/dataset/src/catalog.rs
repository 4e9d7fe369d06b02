//! The catalog: finds the model and the weather of a building by its name.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

use b2b_building::description::Origin;
use b2b_building::import::{Imported, Notes};
use b2b_building::{BuildingType, Class, Controls, Model, PreparedBuilding, design_days, import};
use b2b_climate::{EpwFile, Place, Site};
use b2b_energyplus::install::{Cache, Engine, Progress};
use b2b_energyplus::{Host, Library};

use crate::{Building, BuildingId, Control, Preparation};
use crate::{Error, Result, archetype, commercial};

/// The name of a building: `OfficeSmall`, `OfficeSmall-0042` or `my.idf`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum BuildingName {
    /// The base model of a type.
    Type(BuildingType),
    /// A building of the dataset.
    Id(BuildingId),
    /// A user's model.
    Model(PathBuf),
}

/// The location of a building, if not the default, its interface, and the permissions of a user's model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Placement {
    /// A known place.
    pub place: Option<&'static Place>,
    /// A weather file (EPW). It takes precedence over a place.
    pub weather: Option<PathBuf>,
    /// Whether a user's model may run code and open files outside its folder ([`import::read`]).
    pub allow_external: bool,
    /// Control interface: the actuators of the systems, or the setpoints of every zone.
    pub control: Control,
    /// Whether a user's model keeps its design days instead of the weather file's.
    pub keep_design_days: bool,
    /// Folder of EnergyPlus's Transition programs, which convert a user's old IDF instead of this project's rules.
    pub transition: Option<PathBuf>,
}

/// Finds buildings; caches prototypes and sites.
#[derive(Debug)]
pub struct Catalog {
    library: Library,
    engine: Engine,
    cache: Cache,
    prototypes: Mutex<HashMap<BuildingType, Arc<Model>>>,
    /// By weather file and its content.
    sites: Mutex<HashMap<(PathBuf, String), Arc<Site>>>,
}

/// A building of the catalog: its model before sizing, and its weather.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its name.
    pub name: BuildingName,
    /// Its class; `None` for a user's model.
    pub class: Option<Class>,
    /// Whether its model is a prototype that ships with the engine ([`Placement::is_prototype`]).
    pub prototype: bool,
    /// Name of the place, or of the weather file.
    pub place: String,
    /// The weather file.
    pub weather: PathBuf,
    /// The site of the weather file.
    pub site: Arc<Site>,
    /// Control interface.
    pub control: Control,
    /// Whether the model or an agent controls it.
    pub controls: Controls,
    /// The model before sizing.
    pub model: Model,
    /// Notes from reading a user's model.
    pub notes: Notes,
}

impl Catalog {
    /// Loads the engine; downloads it when it is not in the cache.
    ///
    /// # Errors
    /// [`Error::Install`] and [`Error::Engine`].
    pub fn open(progress: &mut dyn Progress) -> Result<Self> {
        let engine = Engine::ensure(progress)?;
        let library = Library::load(&engine.library)?;
        library.check_version()?;
        Ok(Self {
            library,
            engine,
            cache: Cache::from_env()?,
            prototypes: Mutex::default(),
            sites: Mutex::default(),
        })
    }

    /// Lets other processes read and size models, because a model may crash the engine.
    #[must_use]
    pub fn hosted_by(self, host: Arc<dyn Host>) -> Self {
        Self { library: self.library.hosted_by(host), ..self }
    }

    /// Returns the engine.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// Finds a building. Its weather is downloaded or generated when it is not in the cache.
    ///
    /// # Errors
    /// [`Error::HasPlace`], [`Error::NoWeather`] and [`Error::HasDesignDays`] when the placement does not fit the name;
    /// errors of the weather file and the model.
    pub fn find(
        &self,
        name: &BuildingName,
        placement: &Placement,
        progress: &mut dyn Progress,
    ) -> Result<Found> {
        if placement.keep_design_days && !matches!(name, BuildingName::Model(_)) {
            return Err(Error::HasDesignDays { name: name.to_string() });
        }
        let (place, weather) = self.weather(name, placement, progress)?;
        let site = self.site(&weather)?;
        let (model, notes) = match name {
            BuildingName::Model(path) => self.own_model(path, placement, &site)?,
            _ => (self.model(name, placement, &site)?, Notes::default()),
        };
        let class = placement.class(name, &weather)?;
        let prototype = placement.is_prototype(name);
        let (control, controls) = (placement.control, placement.control.into());
        Ok(Found {
            name: name.clone(),
            class,
            prototype,
            place,
            weather,
            site,
            control,
            controls,
            model,
            notes,
        })
    }

    /// Returns the model of a generated building, before sizing, and its weather file.
    ///
    /// # Errors
    /// The errors of [`Building::weather`] and [`Building::model`].
    pub fn generate(&self, building: &Building, progress: &mut dyn Progress) -> Result<(Model, PathBuf)> {
        let weather = building.weather(&self.cache, progress)?;
        let model = building.model(&*self.prototype(building.building_type())?, &*self.site(&weather)?)?;
        Ok((model, weather))
    }

    fn weather(
        &self,
        name: &BuildingName,
        placement: &Placement,
        progress: &mut dyn Progress,
    ) -> Result<(String, PathBuf)> {
        if let Some(path) = &placement.weather {
            check_weather(path)?;
            let name = model_name(path);
            return Ok((name, path.clone()));
        }
        let place = match (name, placement.place) {
            (BuildingName::Id(id), None) => {
                let building = &crate::row(*id).building;
                return Ok((building.place().to_owned(), building.weather(&self.cache, progress)?));
            }
            (BuildingName::Id(id), Some(_)) => {
                let place = crate::row(*id).building.place().to_owned();
                return Err(Error::HasPlace { building: id.to_string(), place });
            }
            (BuildingName::Type(building_type), None) => Place::find(building_type.home())?,
            (BuildingName::Model(path), None) => {
                import::check_file(path)?;
                return Err(Error::NoWeather { path: path.clone() });
            }
            (_, Some(place)) => place,
        };
        Ok((place.name.to_owned(), place.epw(progress)?))
    }

    /// Returns the model of a building. A base model is unmodified at its default place and adapted to the climate
    /// elsewhere.
    fn model(&self, name: &BuildingName, placement: &Placement, site: &Site) -> Result<Model> {
        let building_type = match name {
            BuildingName::Type(building_type) => *building_type,
            BuildingName::Id(id) => {
                return crate::row(*id).building.model(&*self.prototype(id.building_type())?, site);
            }
            BuildingName::Model(path) => return Ok(self.own_model(path, placement, site)?.0),
        };
        let base = archetype::base_model(building_type, &self.engine, &self.library, site)?;
        match placement.place {
            _ if building_type == BuildingType::SingleFamilyHouse => Ok(base),
            _ if placement.weather.is_some() => commercial::relocated(&base, site),
            Some(place) if place.name != building_type.home() => {
                commercial::code_compliant(&base, building_type, place, site)
            }
            _ => Ok(base),
        }
    }

    /// Returns a user's model with the design days of the weather, unless it keeps its own, and notes on it.
    fn own_model(&self, path: &Path, placement: &Placement, site: &Site) -> Result<(Model, Notes)> {
        let options = import::Options {
            allow_external: placement.allow_external,
            transition: placement.transition.as_deref(),
        };
        let Imported { mut model, mut notes } = import::read_with_notes(path, &self.library, options)?;
        design_days::of_imported(&mut model, site, placement.keep_design_days, &mut notes);
        notes.calendar = import::calendar::note(&model, site);
        notes.warnings.extend(import::calendar::skipped_leap_day(site));
        Ok((model, notes))
    }

    fn prototype(&self, building_type: BuildingType) -> Result<Arc<Model>> {
        remembered(&self.prototypes, &building_type, || {
            archetype::prototype(building_type, &self.engine, &self.library)
        })
    }

    fn site(&self, weather: &Path) -> Result<Arc<Site>> {
        let content = EpwFile::open(weather)?.sha256().to_owned();
        remembered(&self.sites, &(weather.to_owned(), content), || Ok(Site::read(weather)?))
    }
}

/// Returns the cached value of a key, computed on first use.
fn remembered<K: Clone + Eq + std::hash::Hash, V>(
    known: &Mutex<HashMap<K, Arc<V>>>,
    key: &K,
    make: impl FnOnce() -> Result<V>,
) -> Result<Arc<V>> {
    let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(value) = known.get(key) {
        return Ok(Arc::clone(value));
    }
    let value = Arc::new(make()?);
    known.insert(key.clone(), Arc::clone(&value));
    Ok(value)
}

impl Found {
    /// Leaves the building to its own controls if the controller commands no actuators. Any other controller gets the
    /// placement's control interface.
    #[must_use]
    pub fn under(self, wanted: Controls) -> Self {
        match wanted {
            Controls::Own => Self { controls: Controls::Own, ..self },
            Controls::Actuators | Controls::Setpoints => self,
        }
    }

    /// Sizes the building and makes it controllable: every system, or the supported ones of a user's model.
    ///
    /// # Errors
    /// The errors of [`Preparation::run`].
    pub fn prepare(self, library: &Library) -> Result<PreparedBuilding> {
        let (weather, notes) = (self.weather.clone(), self.notes.clone());
        Ok(Preparation::from(self).run(&weather, library)?.with_notes(notes))
    }
}

impl From<Found> for Preparation {
    fn from(found: Found) -> Self {
        Self {
            own: matches!(found.name, BuildingName::Model(_)),
            name: found.control.name_of(&found.name),
            class: found.class,
            prototype: found.prototype,
            controls: found.controls,
            model: found.model,
        }
    }
}

impl Placement {
    /// Returns whether a building is a prototype that ships with the engine: unmodified at its default place, or sized
    /// for a weather file. Houses are generated, and other types are adapted to the code at other places.
    pub fn is_prototype(&self, name: &BuildingName) -> bool {
        match name {
            BuildingName::Type(BuildingType::SingleFamilyHouse) => false,
            BuildingName::Type(building_type) => {
                self.weather.is_some() || self.place.is_none_or(|place| place.name == building_type.home())
            }
            BuildingName::Id(_) | BuildingName::Model(_) => false,
        }
    }

    /// The class of a building. With a user's weather file, its climate zone follows from the hours of the file.
    fn class(&self, name: &BuildingName, weather: &Path) -> Result<Option<Class>> {
        let building_type = match name {
            BuildingName::Model(_) => return Ok(None),
            BuildingName::Id(id) if self.weather.is_none() => {
                return Ok(Some(crate::row(*id).building.class()));
            }
            BuildingName::Id(id) => id.building_type(),
            BuildingName::Type(building_type) => *building_type,
        };
        let zone = match &self.weather {
            Some(_) => EpwFile::open(weather)?.year()?.map(|year| year.zone()),
            None => {
                let home = || Place::find(building_type.home());
                Some(self.place.map_or_else(home, Ok)?.ashrae_zone.to_owned())
            }
        };
        Ok(Some(Class::new(building_type, zone.as_deref())))
    }

    /// Returns the properties of a building that its model does not contain.
    pub fn origin(&self, name: &BuildingName) -> Origin {
        match name {
            BuildingName::Id(id) => crate::row(*id).building.origin(),
            BuildingName::Model(_) | BuildingName::Type(BuildingType::SingleFamilyHouse) => Origin::default(),
            BuildingName::Type(_) if self.weather.is_some() => Origin::commercial(None),
            BuildingName::Type(building_type) => {
                let home = || Place::find(building_type.home()).ok();
                Origin::commercial(self.place.or_else(home).map(|place| place.ashrae_zone))
            }
        }
    }
}

impl BuildingName {
    /// Returns the type; `None` for a user's model.
    pub fn building_type(&self) -> Option<BuildingType> {
        match self {
            Self::Type(building_type) => Some(*building_type),
            Self::Id(id) => Some(id.building_type()),
            Self::Model(_) => None,
        }
    }

    /// Returns the file of a user's model; `None` for other buildings.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Model(path) => Some(path),
            Self::Type(_) | Self::Id(_) => None,
        }
    }
}

impl fmt::Display for BuildingName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Type(building_type) => building_type.fmt(f),
            Self::Id(id) => id.fmt(f),
            Self::Model(path) => f.write_str(&model_name(path)),
        }
    }
}

/// Returns the name of a model: its file's without the extension, unless a building of the dataset has that name.
fn model_name(path: &Path) -> String {
    let of = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let stem = of(path.file_stem());
    match Control::split_name(&stem).0.parse() {
        Ok(BuildingName::Type(_) | BuildingName::Id(_)) => of(path.file_name()),
        Ok(BuildingName::Model(_)) | Err(_) => stem,
    }
}

impl FromStr for BuildingName {
    type Err = Error;

    /// Model files have an extension or a folder, ids contain a dash, and types do not.
    fn from_str(text: &str) -> Result<Self> {
        let path = Path::new(text);
        if import::is_model_file(path) || text.contains(std::path::is_separator) {
            return Ok(Self::Model(path.to_owned()));
        }
        let named = match text.contains('-') {
            true => text.parse().map(Self::Id),
            false => text.parse().map(Self::Type).map_err(Error::from),
        };
        named.map_err(or_model_file)
    }
}

/// Adds the extensions of model files to the error for a name that resembles no type.
fn or_model_file(error: Error) -> Error {
    let is_unlike = |unknown: &b2b_building::Error| {
        matches!(unknown, b2b_building::Error::UnknownType { near: None, .. })
    };
    match error {
        Error::Building(unknown) if is_unlike(&unknown) => Error::NoBuilding { why: unknown.to_string() },
        error => error,
    }
}

/// Checks a weather file before the engine reads it.
fn check_weather(path: &Path) -> Result<()> {
    Ok(EpwFile::open(path)?.check()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_without_a_likeness_may_be_a_model_file_without_its_extension() {
        let said = |text: &str| text.parse::<BuildingName>().unwrap_err().to_string();
        assert!(
            said("mall").contains("`mall`") && said("mall").ends_with("in .idf or .epJSON"),
            "{}",
            said("mall")
        );
        assert!(said("my-mall").ends_with("in .idf or .epJSON"), "{}", said("my-mall"));
        assert!(!said("Warehose").contains(".idf"), "{}", said("Warehose"));
    }

    #[test]
    fn the_class_of_a_building_follows_from_its_name_and_location() {
        let class = |text: &str, place: Option<&str>| {
            let placement =
                Placement { place: place.map(|name| Place::find(name).unwrap()), ..Placement::default() };
            placement.class(&text.parse().unwrap(), Path::new("")).unwrap().map(|class| class.to_string())
        };
        assert_eq!(class("Warehouse", None).unwrap(), "Warehouse in zone 5");
        assert_eq!(class("Warehouse", Some("Miami")).unwrap(), "Warehouse in zone 1");
        assert_eq!(class("SingleFamilyHouse-0003", None).unwrap(), "SingleFamilyHouse");
        assert_eq!(class("my.idf", Some("Miami")), None);
        let prototype = |text: &str, place: Option<&str>| {
            let placement =
                Placement { place: place.map(|name| Place::find(name).unwrap()), ..Placement::default() };
            placement.is_prototype(&text.parse().unwrap())
        };
        assert!(prototype("Warehouse", None) && prototype("Warehouse", Some("Denver")));
        assert!(!prototype("Warehouse", Some("Miami")) && !prototype("SingleFamilyHouse", None));
        assert!(!prototype("Warehouse-0007", None));
        let id = BuildingId::new(BuildingType::OfficeSmall, 42).unwrap();
        let zone = crate::row(id).building.location().ashrae_zone().unwrap();
        let digit = zone.chars().next().unwrap();
        assert_eq!(class("OfficeSmall-0042", None).unwrap(), format!("OfficeSmall in zone {digit}"));
    }

    #[test]
    fn a_building_is_named_by_its_type_its_id_or_its_file() {
        let name = |text: &str| text.parse::<BuildingName>();
        assert_eq!(name("Warehouse").unwrap(), BuildingName::Type(BuildingType::Warehouse));
        assert_eq!(name("warehouse-7").unwrap().to_string(), "Warehouse-0007");
        assert_eq!(name("my-office.IDF").unwrap(), BuildingName::Model("my-office.IDF".into()));
        assert_eq!(name("models/office").unwrap(), BuildingName::Model("models/office".into()));
        assert!(name("Warehouse-1001").unwrap_err().to_string().contains("Warehouse-1000"));
        assert!(name("Warehose").unwrap_err().to_string().contains("Warehouse"));
    }
}
