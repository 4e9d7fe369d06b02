//! The state of a collection, from which another continues.

use b2b_agent::attributes;
use b2b_agent::network::Actor;

use super::building::GraphBuilding;
use super::collector::{FragmentCollector, spaces_of};
use super::order::Purpose;
use super::progress::{EnvironmentProgress, FragmentPhase};
use crate::error::Result;
use crate::state::State;

/// Steps of an environment per replay request.
const REPLAYED: usize = 1024;

impl FragmentCollector {
    /// Returns the state from which [`FragmentCollector::restore`] continues: each environment's episode number, the
    /// actions taken in that episode, and the state of a recurrent actor.
    pub fn state(&self) -> State {
        let mut state = State::default();
        // Between two episodes, an environment has the state of the next one.
        let is_between = |progress: &EnvironmentProgress| progress.phase == FragmentPhase::Starting;
        let episodes: Vec<u64> = self.progress.iter().map(|progress| progress.place().0).collect();
        state.put_u64("episodes", &episodes);
        state.put_u64("counts", &[self.rollouts, self.ended, self.lost]);
        for (index, progress) in self.progress.iter().enumerate() {
            state.put_f32(&actions_of(index), if is_between(progress) { &[] } else { &progress.actions });
            if self.state > 0 && !progress.forgets(self.memory_episodes) {
                state.put_f32(&state_of(index), &progress.state);
            }
        }
        state
    }

    /// Continues from a state: every environment begins its episode again and replays its actions.
    ///
    /// # Errors
    /// When the state has another number of environments, and when an environment cannot begin its episode.
    pub fn restore(&mut self, state: &State, actor: &Actor) -> Result<()> {
        [self.rollouts, self.ended, self.lost] = state.read_u64("counts")?;
        let episodes = state.values_u64("episodes", self.progress.len())?;
        let skipped: Vec<u64> = episodes.iter().map(|episodes| episodes.saturating_sub(1)).collect();
        self.environments.reset_after(self.seed, &skipped)?;
        for (index, episodes) in episodes.into_iter().enumerate() {
            let spaces = spaces_of(&self.environments, index)?;
            let building = GraphBuilding::of(self.interface, self.by_zone, spaces)?;
            let scale = (self.scale)(spaces)? as f32;
            let attributes = attributes(self.interface.observation, spaces)?;
            let actions = state.values_f32(&actions_of(index))?;
            let mut progress = EnvironmentProgress {
                episodes,
                actions,
                ..EnvironmentProgress::new(scale, building, attributes)
            };
            progress.state = vec![0.0; self.state_of(actor)];
            if !progress.state.is_empty() && !progress.forgets(self.memory_episodes) {
                state.read_f32(&state_of(index), &mut progress.state)?;
            }
            self.progress[index] = progress;
        }
        self.replay(actor)
    }

    /// Replays the actions of all episodes in progress, in chunks.
    fn replay(&mut self, actor: &Actor) -> Result<()> {
        let width = self.widths.action;
        let rows = |progress: &EnvironmentProgress| progress.actions.len() / width;
        let longest = self.progress.iter().map(rows).max().unwrap_or(0);
        self.share(actor, REPLAYED)?;
        for first in (0..longest).step_by(REPLAYED) {
            self.begin_rollout();
            // An environment whose episode was lost has none left.
            let left = |progress: &EnvironmentProgress| rows(progress).saturating_sub(first).min(REPLAYED);
            let mut steps: Vec<usize> = self.progress.iter().map(left).collect();
            for (index, steps) in steps.iter().enumerate().filter(|(_, steps)| **steps > 0) {
                let actions = &self.progress[index].actions[first * width..][..steps * width];
                self.memory.write(self.block(index).action(0), actions);
            }
            self.run(actor, Purpose::Replay, &mut steps)?;
        }
        Ok(())
    }
}

/// Returns the name of an environment's actions in a state.
fn actions_of(environment: usize) -> String {
    format!("actions.{environment}")
}

/// Returns the name of the state of a recurrent actor in an environment.
fn state_of(environment: usize) -> String {
    format!("states.{environment}")
}
