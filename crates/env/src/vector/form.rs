//! How buildings of different sizes share one width of observations and actions.

use std::sync::Arc;

use crate::action::ActionSpace;
use crate::observation::Slot;
use crate::spaces::Spaces;
use crate::{Error, Result};

/// Gives the observations and actions of all buildings one width.
pub trait Form: Send {
    /// Numbers in a row of actions and in a row of observations.
    fn widths(&self) -> (usize, usize);

    /// The form of an episode of a building.
    ///
    /// # Errors
    /// When the building does not fit. The environment is lost then.
    fn episode(&mut self, spaces: &Arc<Spaces>) -> Result<Box<dyn EpisodeForm>>;
}

/// The form of one episode.
pub trait EpisodeForm: Send {
    /// Names and bounds of the actuators that a row of actions begins with; the rest of the row is padding.
    fn actions(&self) -> &ActionSpace;

    /// What the numbers in a row of observations are.
    fn slots(&self) -> Vec<RowSlot>;

    /// Completes a row of actions to an action of the building in physical units, with the observation before the step.
    fn act(&mut self, observation: &[f64], row: &[f64], action: &mut [f64]);

    /// Arranges an observation in a row, all of which it writes.
    fn observe(&self, observation: &[f64], row: &mut [f64]);
}

/// A number in a row of observations.
#[derive(Clone, Debug, PartialEq)]
pub struct RowSlot {
    /// Name, `padding` if it is always 0.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl RowSlot {
    /// A slot that is always 0.
    pub fn padding() -> Self {
        Self { name: "padding".into(), unit: "1", low: 0.0, high: 0.0 }
    }
}

impl From<&Slot> for RowSlot {
    fn from(slot: &Slot) -> Self {
        Self { name: slot.name.clone(), unit: slot.unit, low: slot.low, high: slot.high }
    }
}

/// The vectors of a building as they are, followed by zeros.
#[derive(Clone, Copy, Debug)]
pub struct Padded {
    /// Numbers in a row of actions and in a row of observations.
    pub widths: (usize, usize),
}

impl Padded {
    /// The form that fits the largest of some buildings.
    pub fn fitting<'a>(all: impl IntoIterator<Item = &'a Spaces>) -> Self {
        let largest = |(actions, observations): (usize, usize), spaces: &Spaces| {
            (actions.max(spaces.action.len()), observations.max(spaces.observation.len()))
        };
        Self { widths: all.into_iter().fold((0, 0), largest) }
    }
}

impl Form for Padded {
    fn widths(&self) -> (usize, usize) {
        self.widths
    }

    fn episode(&mut self, spaces: &Arc<Spaces>) -> Result<Box<dyn EpisodeForm>> {
        let (actions, observations) = self.widths;
        for (what, width, most) in [
            ("actuators", spaces.action.len(), actions),
            ("observation slots", spaces.observation.len(), observations),
        ] {
            if width > most {
                return Err(Error::TooWide { name: spaces.building.name.clone(), what, width, most });
            }
        }
        Ok(Box::new(PaddedEpisode { spaces: Arc::clone(spaces), width: observations }))
    }
}

struct PaddedEpisode {
    spaces: Arc<Spaces>,
    /// Numbers in a row of observations.
    width: usize,
}

impl EpisodeForm for PaddedEpisode {
    fn actions(&self) -> &ActionSpace {
        &self.spaces.action
    }

    fn slots(&self) -> Vec<RowSlot> {
        let slots = self.spaces.observation.slots().iter().map(RowSlot::from);
        slots.chain(std::iter::repeat_with(RowSlot::padding)).take(self.width).collect()
    }

    fn act(&mut self, _: &[f64], row: &[f64], action: &mut [f64]) {
        action.copy_from_slice(&row[..action.len()]);
    }

    fn observe(&self, observation: &[f64], row: &mut [f64]) {
        let (values, padding) = row.split_at_mut(observation.len());
        values.copy_from_slice(observation);
        padding.fill(0.0);
    }
}
