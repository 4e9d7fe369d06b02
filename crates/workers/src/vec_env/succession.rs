//! The episodes of an environment in succession: draw, preparation, start and end.

use std::sync::Arc;
use std::time::Instant;

use super::{Autoreset, Next, State, VecEnv};
use crate::batch::rest;
use crate::episode::Episode;
use crate::episode::episode_options::EpisodeOptions;
use crate::form::{Arrangement, Padded};
use crate::setting::EpisodeSetting;
use b2b_env::Spaces;
use b2b_env::{Environment, Error, Result};

impl VecEnv {
    /// Draws the next episode and starts its preparation.
    pub(super) fn draw(&mut self, index: usize) -> Result<()> {
        let one = &mut self.environments[index];
        if one.next.is_none() {
            let draw = self.sampler.draw(index, &mut one.random)?;
            let reservation = self.workers.reserve(&draw.setting)?;
            one.next = Some(Next { draw, reservation });
        }
        Ok(())
    }

    /// Sets the widths to the largest of the next episodes.
    pub(super) fn measure(&mut self) -> Result<()> {
        let next = self.environments.iter().filter_map(|one| one.next.as_ref());
        let settings: Vec<EpisodeSetting> = next.map(|next| next.draw.setting.clone()).collect();
        let all = self.workers.prepare_all(&settings)?;
        let form = Padded::fitting(&all, Arrangement::InOrder);
        self.widths = form.widths;
        self.observations = vec![0.0; self.len() * self.widths.1];
        self.form = Box::new(form);
        Ok(())
    }

    /// Begins the next episode as soon as it is prepared.
    pub(super) fn begin(&mut self, index: usize) {
        self.abandon(index);
        self.environments[index].state = State::Preparing;
        if let Err(error) = self.draw(index) {
            return self.lose(index, error.to_string());
        }
        let one = &mut self.environments[index];
        // The first episode after a reset cannot be prepared during another.
        let is_late = one.next.as_ref().is_some_and(|next| !next.reservation.is_prepared());
        if is_late && one.form.is_some() {
            one.waiting = Some(Instant::now());
            self.statistics.waits += 1;
        }
    }

    /// Begins the episodes whose preparation is done.
    fn begin_prepared(&mut self) {
        for index in 0..self.len() {
            if self.environments[index].state != State::Preparing {
                continue;
            }
            let Some(next) = &self.environments[index].next else { continue };
            match next.reservation.spaces() {
                Ok(None) => {}
                Ok(Some(spaces)) => {
                    if let Err(error) = self.start(index, spaces) {
                        self.lose(index, error.to_string());
                    }
                }
                Err(error) => self.lose_those_like(index, &error),
            }
        }
    }

    /// Begins the next episode of an environment.
    fn start(&mut self, index: usize, spaces: Arc<Spaces>) -> Result<()> {
        let form = self.form.episode(&spaces)?;
        let processor = self.processor(index);
        let one = &mut self.environments[index];
        // Its template is kept until the episode waits for a copy.
        let Some(Next { draw, reservation }) = one.next.take() else { return Ok(()) };
        let options = EpisodeOptions { max_steps: draw.steps, processor, finish_run: false };
        let episode = Episode::new(self.workers.clone(), draw.setting, Arc::clone(&spaces));
        let episode = one.episode.insert(episode.with_options(options));
        episode.begin()?;
        drop(reservation);
        one.state = State::Starting;
        one.form = Some(form);
        one.action.resize(spaces.action.len(), 0.0);
        let before = one.spaces.replace(spaces);
        let changes =
            before.zip(one.spaces.as_ref()).is_some_and(|(old, new)| old.building.name != new.building.name);
        self.statistics.episodes += 1;
        self.statistics.building_changes += u64::from(changes);
        self.statistics.waited += one.waiting.take().map(|since| since.elapsed()).unwrap_or_default();
        // The episode after this one is prepared while this one runs. A failed draw is repeated, and reported, when its
        // turn comes.
        let _ = self.draw(index);
        Ok(())
    }

    /// Returns the processor to pin an environment to; `None` if there are spare processors, beyond the owner's.
    fn processor(&self, index: usize) -> Option<u32> {
        (self.len() >= self.workers.region().processors()).then_some(index as u32)
    }

    /// Waits until `count` environments are idle.
    pub(super) fn wait(&mut self, count: usize) -> Result<()> {
        loop {
            let done = self.workers.region().done();
            self.workers.lock().advance_all_when_due();
            self.begin_prepared();
            (0..self.len()).for_each(|index| self.take_back(index));
            let busy = self.environments.iter().filter(|one| one.is_busy()).count();
            if self.len() - busy >= count {
                return Ok(());
            }
            let preparing = self.environments.iter().filter(|one| one.state == State::Preparing).count();
            // The end of a preparation is a separate event; steps are awaited together.
            let enough = if preparing > 0 { self.len() - busy + preparing + 1 } else { count };
            rest(&self.workers, &mut self.environments, |one| one.episode.as_mut(), enough, done)?;
        }
    }

    /// Takes the outcome of an idle environment.
    fn take_back(&mut self, index: usize) {
        let one = &mut self.environments[index];
        let away = matches!(one.state, State::Stepping | State::Starting);
        let Some(episode) = one.episode.as_ref().filter(|episode| away && !episode.is_busy()) else { return };
        if let Some(why) = episode.lost() {
            let why = why.to_owned();
            return self.lose(index, why);
        }
        let observation = episode.observation();
        let row = &mut self.observations[index * self.widths.1..][..self.widths.1];
        if let Some(form) = &one.form {
            form.observe(observation, row);
        }
        if one.state == State::Stepping {
            self.rewards[index] = episode.reward();
            self.terms[index] = episode.terms();
        }
        one.fragment_steps = episode.fragment_steps();
        one.state = State::Ready;
        if episode.is_truncated() {
            self.truncated[index] = true;
            one.final_metrics = episode.metrics().cloned();
            one.final_observation.clear();
            one.final_observation.extend_from_slice(row);
            match self.autoreset {
                Autoreset::SameStep => self.begin(index),
                Autoreset::NextStep | Autoreset::Disabled => self.abandon(index),
            }
        }
    }

    /// Reports an episode as lost: truncated at its last observation. The next begins as usual, but never within the
    /// same step, so that an episode that fails immediately does not fail forever.
    fn lose(&mut self, index: usize, why: String) {
        let state = self.environments[index].state;
        self.abandon(index);
        // With SameStep, the previous episode may have ended within this step; its end is reported, too.
        let has_ended = self.autoreset == Autoreset::SameStep && self.truncated[index];
        let row = &self.observations[index * self.widths.1..][..self.widths.1];
        let one = &mut self.environments[index];
        one.lost = Some(why);
        one.waiting = None;
        match state {
            State::Stepping => {
                one.final_observation.clear();
                one.final_observation.extend_from_slice(row);
            }
            // The draw itself was lost.
            State::Preparing => one.next = None,
            State::Starting | State::Ready | State::Over => {}
        }
        if state == State::Stepping || !has_ended {
            one.final_metrics = None;
            one.fragment_steps = 0;
        }
        self.truncated[index] = true;
    }

    /// Loses every environment that waits for a failed preparation.
    fn lose_those_like(&mut self, first: usize, error: &Error) {
        let Some(failed) = self.environments[first].next.take() else { return };
        self.lose(first, error.to_string());
        for index in 0..self.len() {
            let one = &mut self.environments[index];
            let Some(next) = one.next.as_mut().filter(|next| next.reservation.is(&failed.reservation)) else {
                continue;
            };
            if one.state == State::Preparing {
                self.lose(index, error.to_string());
            } else if let Ok(again) = self.workers.reserve(&next.draw.setting) {
                // The preparation is retried for a future episode.
                next.reservation = again;
            }
        }
    }

    pub(super) fn abandon(&mut self, index: usize) {
        let one = &mut self.environments[index];
        one.episode = None;
        one.state = State::Over;
    }
}
