//! Preparation of buildings through a cache on disk, because sizing requires a run of the engine.

pub(crate) mod cache;

use std::path::Path;

use b2b_building::hvac::{KINDS, Unsupported};
use b2b_building::import::external;
use b2b_building::{Class, Controls, Model, PreparedBuilding, ZoneYear};
use b2b_climate::EpwFile;
use b2b_energyplus::Library;

use self::cache::PreparationCache;
use crate::Result;
use crate::house;

/// A model to be prepared for control.
#[derive(Clone, Debug, PartialEq)]
pub struct Preparation {
    /// Name of the building.
    pub name: String,
    /// Building type and climate zone, if known.
    pub class: Option<Class>,
    /// Whether the model is a prototype that ships with the engine ([`crate::Placement::is_prototype`]).
    pub prototype: bool,
    /// Whether it is a user's model, whose unsupported systems keep their own controls.
    pub own: bool,
    /// Who controls the building.
    pub controls: Controls,
    /// The model before sizing.
    pub model: Model,
}

impl Preparation {
    /// Returns the preparation of a model without a class, controlled through its actuators.
    pub fn new(name: &str, model: Model) -> Self {
        Self {
            name: name.to_owned(),
            class: None,
            prototype: false,
            own: false,
            controls: Controls::default(),
            model,
        }
    }

    /// Sizes the model for a weather file and makes it controllable, or returns a cached result.
    ///
    /// # Errors
    /// The errors of [`PreparedBuilding::new`].
    pub fn run(self, weather: &Path, library: &Library) -> Result<PreparedBuilding> {
        let cache = PreparationCache::from_env();
        let key = cache.as_ref().and_then(|_| self.key(weather, library));
        let (Some(cache), Some(key)) = (cache, key) else { return self.run_anew(weather, library) };
        if let Some(building) = cache.read(&key) {
            return Ok(building);
        }
        let building = self.run_anew(weather, library)?;
        cache.write(&key, &building);
        Ok(building)
    }

    /// Returns the prepared building if the cache has it, without running the engine.
    pub fn cached(&self, weather: &Path, library: &Library) -> Option<PreparedBuilding> {
        PreparationCache::from_env()?.read(&self.key(weather, library)?)
    }

    fn run_anew(self, weather: &Path, library: &Library) -> Result<PreparedBuilding> {
        let Self { name, model, .. } = self;
        let unsupported = if self.own { Unsupported::LeftAlone } else { Unsupported::Refused };
        let lacks_thermostat = house::lacks_thermostat(&model);
        let complete = |model: &mut Model, years: &[ZoneYear]| {
            if lacks_thermostat {
                house::add_thermostat(model, years);
            }
        };
        let building = match self.controls {
            Controls::Setpoints => {
                PreparedBuilding::under_setpoints(&name, model, weather, library, unsupported, complete)
            }
            Controls::Actuators => {
                PreparedBuilding::with_kinds(&name, model, weather, library, &KINDS, unsupported)
            }
            Controls::Own => {
                PreparedBuilding::under_own_controls(&name, model, weather, library, unsupported, complete)
            }
        };
        let mut building = building?.of_class(self.class);
        building.prototype = self.prototype;
        Ok(building)
    }

    /// Returns the digest of everything that the result depends on; `None` if a file cannot be read.
    fn key(&self, weather: &Path, library: &Library) -> Option<String> {
        use b2b_base::digest::sha256;
        let Self { name, class, prototype, own, controls, model } = self;
        let files = external::files(model).into_iter().map(|path| std::fs::read(path).map(sha256));
        let files: std::io::Result<Vec<_>> = files.collect();
        let inputs = (
            concat!(env!("CARGO_PKG_VERSION"), " ", env!("B2B_PREPARATION_SOURCES")),
            library.version(),
            EpwFile::open(weather).ok()?.sha256().to_owned(),
            sha256(serde_json::to_vec(model).ok()?),
            files.ok()?,
            (name, class, prototype, own, controls),
        );
        Some(sha256(serde_json::to_vec(&inputs).ok()?))
    }
}
