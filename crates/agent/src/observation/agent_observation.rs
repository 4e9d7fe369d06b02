//! The observation of an agent in one building.

use std::sync::Arc;

use b2b_env::Spaces;
use b2b_workers::Arrangement;

use super::feature::{Context, Feature, LinearFeature};
use super::features::features;
use super::known::{attribute_features, forecast_features};
use super::memory::Memory;
use super::options::{ObservationForm, ObservationOptions};
use super::{outdoor, scaled};
use crate::Result;

/// The observation of an agent in an episode of a building.
#[derive(Clone, Debug)]
pub struct AgentObservation {
    features: Vec<Feature>,
    memory: Memory,
    /// Outdoor temperatures at the end of each hour of the year, °C; empty without a forecast.
    outdoor: Vec<f64>,
}

impl AgentObservation {
    /// Returns the observation for a building with these [`attributes`](super::attributes). With a base controller, features
    /// include its action.
    ///
    /// # Errors
    /// [`Error::Weather`](crate::Error::Weather) for an unreadable weather file.
    pub fn new(
        options: ObservationOptions,
        attributes: &[f64],
        spaces: &Arc<Spaces>,
        has_base: bool,
    ) -> Result<Self> {
        let mut features = match options.form {
            ObservationForm::Raw => scaled::features(&Arrangement::InOrder.of(spaces)),
            ObservationForm::Roles => scaled::features(&Arrangement::ByRole.of(spaces)),
            ObservationForm::Features => features(spaces, has_base),
        };
        features.extend(attribute_features(attributes, spaces));
        features.extend(forecast_features(options.forecast, spaces));
        let outdoor = outdoor::temperatures(options.forecast, spaces)?;
        Ok(Self { outdoor, ..Self::of_features(features, spaces) })
    }

    /// Creates an observation of these slots, without a forecast.
    pub(super) fn of_features(features: Vec<Feature>, spaces: &Spaces) -> Self {
        Self { features, memory: Memory::new(spaces), outdoor: Vec::new() }
    }

    /// Returns the slots in order.
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Returns its slots as linear functions of the environment's slots; `None` if a slot is not linear.
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

    /// Writes the observation of the agent. Called once for every observation of the environment, in order. `previous`
    /// is the agent's last action, `base` the base controller's next one; both in [-1, 1].
    pub fn write(&mut self, observation: &[f64], previous: &[f32], base: &[f32], row: &mut [f32]) {
        self.memory.remember(observation);
        let Self { memory, outdoor, .. } = &*self;
        let context = Context { observation, memory, outdoor, previous, base };
        for (value, feature) in row.iter_mut().zip(&self.features) {
            *value = feature.value(&context) as f32;
        }
    }
}
