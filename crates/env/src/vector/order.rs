//! What a process is started for.

use std::path::{Path, PathBuf};

use b2b_building::{Class, Model, PreparedBuilding};
use b2b_dataset::{BuildingName, Found};
use b2b_energyplus::Library;
use serde::{Deserialize, Serialize};

use crate::env::Env;
use crate::spaces::EpisodeConfig;

/// A building to make an environment of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// One that is ready.
    Prepared(Box<PreparedBuilding>),
    /// One that has to be sized and made controllable first.
    Model {
        /// Its name.
        name: String,
        /// What it is of.
        class: Option<Class>,
        /// Whether it is a prototype as it comes with the engine.
        prototype: bool,
        /// Whether it is a user's own, of which as much is made controllable as can be.
        own: bool,
        /// The model as it was generated or read.
        model: Box<Model>,
    },
}

impl From<Found> for Source {
    fn from(found: Found) -> Self {
        Self::Model {
            own: matches!(found.name, BuildingName::Model(_)),
            name: found.name.to_string(),
            class: found.class,
            prototype: found.prototype,
            model: Box::new(found.model),
        }
    }
}

impl Source {
    /// A building of the generator, whose class is known.
    pub fn generated(name: String, class: Class, model: Model) -> Self {
        Self::Model { name, class: Some(class), prototype: false, own: false, model: Box::new(model) }
    }

    /// The building, sized under a weather file and made controllable if it is not yet.
    ///
    /// # Errors
    /// Those of [`PreparedBuilding::new`].
    pub fn prepare(self, weather: &Path, library: &Library) -> b2b_dataset::Result<PreparedBuilding> {
        match self {
            Self::Prepared(building) => Ok(*building),
            Self::Model { name, class, prototype, own, model } => {
                let make = if own { PreparedBuilding::as_far_as_possible } else { PreparedBuilding::new };
                let mut building = make(&name, *model, weather, library)?.of_class(class);
                building.prototype = prototype;
                Ok(building)
            }
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            Self::Prepared(building) => &building.name,
            Self::Model { name, .. } => name,
        }
    }
}

/// What a template is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Order {
    /// The engine's library.
    pub(super) library: PathBuf,
    pub(super) source: Source,
    pub(super) episode: EpisodeConfig,
}

impl Order {
    /// The environment, before its first reset.
    pub(super) fn env(self) -> Result<Env, Box<dyn std::error::Error>> {
        let library = Library::load(&self.library)?;
        let building = self.source.prepare(&self.episode.weather, &library)?;
        Ok(Env::new(library, building.into(), self.episode)?)
    }
}
