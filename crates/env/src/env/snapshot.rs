//! Snapshots of an [`Env`] that replay its actions, for systems that cannot copy a process.

use serde::{Deserialize, Serialize};

use super::Env;
use crate::spaces::EpisodeConfig;
use crate::{Error, Result};

/// A point in an episode: the building, the episode, and every action up to that point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    building: String,
    episode: EpisodeConfig,
    steps: usize,
    /// The given actions, concatenated.
    actions: Vec<f64>,
}

impl Env {
    /// Records the actions of an episode for [`Env::snapshot`]. Some steps then allocate.
    #[must_use]
    pub fn keep_history(mut self) -> Self {
        self.history = Some(Vec::new());
        self
    }

    /// The current point of the episode. `None` without [`Env::keep_history`] or an episode in progress.
    pub fn snapshot(&self) -> Option<Snapshot> {
        let actions = self.history.clone().filter(|_| self.engine.is_some())?;
        let (building, episode) = (self.spaces.building.name.clone(), self.spaces.episode.clone());
        Some(Snapshot { building, episode, steps: self.metrics.steps, actions })
    }

    /// Returns to a snapshot, bit for bit, by restarting and replaying the actions. This works on every system and in
    /// other processes. On Linux, an `Episode` of `b2b-workers` does it in milliseconds.
    ///
    /// # Errors
    /// [`Error::OtherSnapshot`] for a snapshot of another building or episode; the errors of [`Env::reset`] and
    /// [`Env::step`].
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<&[f64]> {
        let spaces = &self.spaces;
        if snapshot.building != spaces.building.name || snapshot.episode != spaces.episode {
            let (taken, here) = (snapshot.building.clone(), spaces.building.name.clone());
            return Err(Error::OtherSnapshot { taken, here });
        }
        self.reset()?;
        let width = self.spaces.action.len();
        for step in 0..snapshot.steps {
            self.step(&snapshot.actions[step * width..][..width])?;
        }
        Ok(&self.observation)
    }
}
