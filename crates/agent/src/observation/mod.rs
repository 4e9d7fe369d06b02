//! Observations of agents: the environment's observation, scaled to numbers of order one.

mod feature;
mod features;
mod known;
mod memory;
mod nodes;
mod options;
mod plan;
mod scaled;

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use b2b_env::Spaces;
use b2b_env::vector::Arrangement;
use serde::{Deserialize, Serialize};

use crate::onnx::LinearFeature;
use crate::{Error, Result};
use feature::Context;
pub use feature::Feature;
pub use known::attributes;
use known::{attribute_features, forecast_features, outdoor_temperatures};
use memory::Memory;
pub use nodes::{NodeForm, NodeSpaces, NodeView};
pub use options::ObservationOptions;
pub use plan::{NodePlan, PlannedNode};

/// The form of an agent's observation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObservationForm {
    /// The observation of the environment, each slot scaled from its bounds to [-1, 1], as in the paper.
    Raw,
    /// As `raw`, with a slot for every zone role in houses: see [`RoleObservation`](b2b_env::RoleObservation).
    Roles,
    /// Features of the state that control needs: errors at several scales, their change and recent mean, targets, calendar
    /// as sines, and the previous and the base controller's action. See `docs/training.md`.
    #[default]
    Features,
}

impl fmt::Display for ObservationForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Raw => "raw",
            Self::Roles => "roles",
            Self::Features => "features",
        })
    }
}

impl FromStr for ObservationForm {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        [Self::Raw, Self::Roles, Self::Features]
            .into_iter()
            .find(|form| form.to_string() == text)
            .ok_or_else(|| Error::UnknownObservation { text: text.to_owned() })
    }
}

/// The observation of an agent in an episode of a building.
#[derive(Clone, Debug)]
pub struct AgentObservation {
    features: Vec<Feature>,
    memory: Memory,
    /// Outdoor temperatures at the end of each hour of the year, °C; empty without a forecast.
    outdoor: Vec<f64>,
}

impl AgentObservation {
    /// Returns the observation for a building with these [`attributes`]. With a base controller, features include its action.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::Forecast`] for a weather file without a forecast.
    pub fn new(
        options: ObservationOptions,
        attributes: &[f64],
        spaces: &Arc<Spaces>,
        has_base: bool,
    ) -> Result<Self> {
        let mut features = match options.form {
            ObservationForm::Raw => scaled::features(&Arrangement::InOrder.of(spaces)),
            ObservationForm::Roles => scaled::features(&Arrangement::ByRole.of(spaces)),
            ObservationForm::Features => features::features(spaces, has_base),
        };
        features.extend(attribute_features(attributes, spaces));
        features.extend(forecast_features(options.forecast, spaces));
        let outdoor = outdoor_temperatures(options.forecast, spaces)?;
        Ok(Self { features, memory: Memory::new(spaces), outdoor })
    }

    /// Returns the slots in order.
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Returns its slots as linear functions of the environment's, if they all are.
    pub(crate) fn linear_features(&self) -> Option<Vec<LinearFeature>> {
        self.features.iter().map(Feature::linear).collect()
    }

    /// Returns the names of the slots in order.
    pub fn names(&self) -> Vec<String> {
        self.features.iter().map(|feature| feature.name.clone()).collect()
    }

    /// Returns the number of slots.
    pub fn width(&self) -> usize {
        self.features.len()
    }

    /// Forgets the previous episode.
    pub fn reset(&mut self) {
        self.memory.reset();
    }

    /// Writes the observation of the agent. Called once for every observation of the environment, in order. `previous` is the
    /// action that the agent gave last, `base` the base controller's next one; both from -1 to 1.
    pub fn write(&mut self, observation: &[f64], previous: &[f32], base: &[f32], row: &mut [f32]) {
        self.memory.remember(observation);
        let Self { memory, outdoor, .. } = &*self;
        let context = Context { observation, memory, outdoor, previous, base };
        for (value, feature) in row.iter_mut().zip(&self.features) {
            *value = feature.value(&context) as f32;
        }
    }
}
