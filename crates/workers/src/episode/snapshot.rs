//! Snapshots of an episode, and episodes that continue from one.

use std::sync::Arc;

use b2b_env::{Error, Result};

use super::episode_options::EpisodeOptions;
use super::{Episode, EpisodePhase};

/// A point in an episode, kept as a process that ends on drop.
#[derive(Debug)]
pub struct Snapshot(Episode);

impl Episode {
    /// Returns a snapshot: a copy of the episode at its current point.
    ///
    /// # Errors
    /// [`Error::Lost`] when the copy fails; [`Error::NotReset`] and [`Error::Busy`] when the episode is not ready.
    pub fn snapshot(&self) -> Result<Snapshot> {
        Ok(Snapshot(self.same()?))
    }

    /// Returns to a snapshot, which remains usable.
    ///
    /// # Errors
    /// [`Error::OtherSnapshot`] for a snapshot of another setting or set of workers; [`Error::Lost`] when the copy
    /// fails, which leaves the episode unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<&[f64]> {
        let kept = &snapshot.0;
        if !self.workers.are(&kept.workers) || !self.setting.is(&kept.setting) {
            let [taken, here] = [kept, self].map(|episode| episode.spaces.building.name.clone());
            return Err(Error::OtherSnapshot { taken, here });
        }
        let mut copy = kept.same()?;
        copy.options = self.options;
        *self = copy;
        Ok(&self.observation)
    }

    /// Returns `count` episodes that continue from the current point of this one, whose engines do not finish their
    /// runs: they have no [`report`](Self::report).
    ///
    /// # Errors
    /// Same as [`Episode::snapshot`].
    pub fn branch(&self, count: usize) -> Result<Vec<Self>> {
        self.copies(count, EpisodeOptions::default())
    }

    /// Returns a copy that continues like this episode to its end, and finishes the engine's run if it does.
    fn same(&self) -> Result<Self> {
        Ok(self.copies(1, EpisodeOptions { processor: None, ..self.options })?.remove(0))
    }

    fn copies(&self, count: usize, options: EpisodeOptions) -> Result<Vec<Self>> {
        self.slot()?;
        let place = self.place.ok_or(Error::NotReset)?;
        let places = self.workers.lock().branch(place, count, options)?;
        let copy = |place| Self {
            workers: self.workers.clone(),
            setting: self.setting.clone(),
            spaces: Arc::clone(&self.spaces),
            options: self.options,
            place: Some(place),
            phase: EpisodePhase::Ready,
            failed_starts: 0,
            observation: self.observation.clone(),
            action: self.action.clone(),
            reward: self.reward,
            terms: self.terms,
            metrics: None,
            report: None,
        };
        Ok(places.into_iter().map(copy).collect())
    }
}

impl Snapshot {
    /// Returns `count` episodes that continue from this point.
    ///
    /// # Errors
    /// Same as [`Episode::snapshot`].
    pub fn branch(&self, count: usize) -> Result<Vec<Episode>> {
        self.0.branch(count)
    }

    /// Returns an episode that continues from this point.
    ///
    /// # Errors
    /// Same as [`Episode::snapshot`].
    pub fn episode(&self) -> Result<Episode> {
        self.0.same()
    }

    /// The observation at this point.
    pub fn observation(&self) -> &[f64] {
        self.0.observation()
    }
}
