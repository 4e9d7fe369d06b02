//! The setting of an episode: a building and the configuration of the episode.

use std::path::PathBuf;
use std::sync::Arc;

use b2b_building::{Class, Controls, Model, PreparedBuilding};
use b2b_dataset::{Control, Found, Preparation};
use b2b_energyplus::Library;
use serde::{Deserialize, Serialize};

use b2b_env::EpisodeConfig;

/// The building of an environment, prepared or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A prepared building.
    Prepared(Box<PreparedBuilding>),
    /// A model that has to be sized and made controllable first.
    Model {
        /// Its name.
        name: String,
        /// Building type and climate zone, if known.
        class: Option<Class>,
        /// Whether it is a prototype shipped with the engine.
        prototype: bool,
        /// Whether it is a user's model, whose unsupported systems keep their own controls.
        own: bool,
        /// Who controls the building.
        #[serde(default)]
        controls: Controls,
        /// The model, as generated or read.
        model: Box<Model>,
        /// The weather file for sizing, regardless of an episode's weather.
        weather: PathBuf,
    },
}

impl From<Found> for Source {
    fn from(found: Found) -> Self {
        let weather = found.weather.clone();
        let Preparation { name, class, prototype, own, controls, model } = found.into();
        Self::Model { name, class, prototype, own, controls, model: Box::new(model), weather }
    }
}

impl Source {
    /// A generated building, whose class is known, with its weather file.
    pub fn generated(name: String, class: Class, model: Model, weather: PathBuf) -> Self {
        let (class, controls, model) = (Some(class), Controls::default(), Box::new(model));
        Self::Model { name, class, prototype: false, own: false, controls, model, weather }
    }

    /// Sets what an agent controls, unless the building is already prepared.
    #[must_use]
    pub fn under(mut self, control: Control) -> Self {
        if let Self::Model { controls, .. } = &mut self {
            *controls = control.into();
        }
        self
    }

    /// Returns the prepared building: sized for its weather file and made controllable, unless it already is.
    ///
    /// # Errors
    /// The errors of [`Preparation::run`].
    pub fn prepare(self, library: &Library) -> b2b_dataset::Result<PreparedBuilding> {
        match self {
            Self::Prepared(building) => Ok(*building),
            Self::Model { name, class, prototype, own, controls, model, weather } => {
                Preparation { name, class, prototype, own, controls, model: *model }.run(&weather, library)
            }
        }
    }

    /// Returns the prepared building, if it is already prepared or cached on disk.
    pub fn cached(&self, library: &Library) -> Option<PreparedBuilding> {
        match self {
            Self::Prepared(building) => Some(PreparedBuilding::clone(building)),
            Self::Model { name, class, prototype, own, controls, model, weather } => {
                let (name, model) = (name.clone(), Model::clone(model));
                let preparation = Preparation {
                    name,
                    class: *class,
                    prototype: *prototype,
                    own: *own,
                    controls: *controls,
                    model,
                };
                preparation.cached(weather, library)
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

/// The setting of an episode: a building, its weather, its days and its task.
#[derive(Clone, Debug)]
pub struct EpisodeSetting {
    /// The building. Settings that share one share its preparation.
    pub source: Arc<Source>,
    /// Weather, period, time step and task.
    pub episode: EpisodeConfig,
}

impl EpisodeSetting {
    /// Creates a setting.
    pub fn new(source: impl Into<Arc<Source>>, episode: EpisodeConfig) -> Self {
        Self { source: source.into(), episode }
    }

    /// Returns whether both have the same building and episode.
    pub(super) fn is(&self, other: &Self) -> bool {
        self.episode == other.episode && self.shares_preparation_with(other)
    }

    /// Returns whether both can use the same prepared building: the same building, sized for the same weather. The
    /// weather of their episodes may differ.
    pub(super) fn shares_preparation_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.source, &other.source)
            || self.source.name() == other.source.name() && self.source == other.source
    }
}
