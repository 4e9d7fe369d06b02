//! The observation of an agent in one building.

use std::sync::Arc;

use b2b_env::{Bands, NextPair, Spaces};
use b2b_workers::Arrangement;

use super::appended::{attribute_features, feedback_features, forecast_features};
use super::feature::{Context, Feature, LinearFeature};
use super::features::features;
use super::memory::Memory;
use super::options::{ObservationForm, ObservationOptions};
use super::past::Past;
use super::supervised::supervised;
use super::{outdoor, scaled};
use crate::Result;
use crate::acting::Driver;

/// The observation of an agent in an episode of a building.
#[derive(Clone, Debug)]
pub struct AgentObservation {
    features: Vec<Feature>,
    memory: Memory,
    /// Outdoor temperatures at the end of each hour of the year, °C; empty without a forecast.
    outdoor: Vec<f64>,
    /// Setpoint bands of an operation task, and each zone's next change of them; none without
    /// supervision.
    bands: Option<Bands>,
    changes: Vec<Option<NextPair>>,
    calendar: [usize; 2],
}

impl AgentObservation {
    /// Returns the observation for a building with these [`attributes`](super::attributes). Features include the action
    /// of the reactive controllers that an agent corrects, or the decisions of the sequences that it supervises.
    ///
    /// # Errors
    /// [`Error::Weather`](crate::Error::Weather) for an unreadable weather file.
    pub(crate) fn new(
        options: ObservationOptions,
        attributes: &[f64],
        spaces: &Arc<Spaces>,
        driver: &Driver,
    ) -> Result<Self> {
        let mut features = match options.form {
            ObservationForm::Raw => scaled::features(&Arrangement::InOrder.of(spaces)),
            ObservationForm::Roles => scaled::features(&Arrangement::ByRole.of(spaces)),
            ObservationForm::Features => match driver.supervisor() {
                Some(supervisor) => supervised(spaces, supervisor),
                None => features(spaces, driver.names(), !driver.base().is_empty()),
            },
        };
        features.extend(attribute_features(attributes, spaces));
        features.extend(forecast_features(options.forecast, spaces));
        if options.feedback {
            let has_actions = options.form == ObservationForm::Features;
            features.extend(feedback_features(if has_actions { &[] } else { driver.names() }));
        }
        let outdoor = outdoor::temperatures(options.forecast, spaces)?;
        Ok(Self { outdoor, ..Self::of_features(features, spaces, driver.supervisor().is_some()) })
    }

    /// Creates an observation of these slots, without a forecast. `previews` adds the next changes of the bands.
    pub(super) fn of_features(features: Vec<Feature>, spaces: &Spaces, previews: bool) -> Self {
        let bands = Bands::of(spaces).filter(|_| previews);
        Self {
            features,
            memory: Memory::new(spaces),
            outdoor: Vec::new(),
            changes: vec![None; bands.as_ref().map_or(0, |_| spaces.controlled_zones().count())],
            bands,
            calendar: [spaces.observation.day_of_year(), spaces.observation.time_of_day()],
        }
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

    /// Writes the observation of the agent. Called once for every observation of the environment, in order.
    pub(crate) fn write(&mut self, observation: &[f64], past: Past<'_>, driver: &Driver, row: &mut [f32]) {
        self.memory.remember(observation);
        if let Some(bands) = &self.bands {
            let [day, hour] = self.calendar.map(|slot| observation[slot]);
            for (zone, change) in self.changes.iter_mut().enumerate() {
                *change = bands.next(zone, day as u32, hour);
            }
        }
        let Self { memory, outdoor, changes, .. } = &*self;
        let decisions = driver.supervisor().map_or(&[][..], |supervisor| supervisor.decisions());
        let base = driver.base();
        let context = Context { observation, memory, outdoor, changes, past, base, decisions };
        for (value, feature) in row.iter_mut().zip(&self.features) {
            *value = feature.value(&context) as f32;
        }
    }
}
