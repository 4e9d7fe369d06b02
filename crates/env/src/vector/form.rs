//! How buildings of different sizes share one width of observations and actions.

use std::sync::Arc;

use crate::action::ActionSpace;
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

    /// Completes a row of actions to an action of the building in physical units, with the observation before the step.
    fn act(&mut self, observation: &[f64], row: &[f64], action: &mut [f64]);

    /// Arranges an observation in a row, all of which it writes.
    fn observe(&self, observation: &[f64], row: &mut [f64]);
}

/// The vectors of a building as they are, followed by zeros.
#[derive(Clone, Copy, Debug)]
pub(super) struct Padded {
    pub(super) widths: (usize, usize),
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
        Ok(Box::new(PaddedEpisode(Arc::clone(spaces))))
    }
}

struct PaddedEpisode(Arc<Spaces>);

impl EpisodeForm for PaddedEpisode {
    fn actions(&self) -> &ActionSpace {
        &self.0.action
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
