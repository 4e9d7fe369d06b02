//! SAC as a learner of a training run.

use b2b_agent::network::Actor;

use super::config::SacConfig;
use super::learner::Sac;
use super::update::SacUpdate;
use crate::error::Result;
use crate::learner::{Learner, LearnerOptions, LearnerSetting};
use crate::random::RandomStream;
use crate::rollout::Rollout;
use crate::state::State;

/// Names of the optimizers in a state.
const ADAMS: [&str; 3] = ["adam.actor", "adam.critics", "adam.temperature"];

impl Learner for Sac {
    fn set_done(&mut self, done: f64) {
        self.done = done;
    }

    fn actor(&self) -> Actor {
        self.networks.actor(&self.parameters)
    }

    fn columns(&self) -> Vec<&'static str> {
        SacUpdate::default().named().map(|(name, _)| name).to_vec()
    }

    fn learn(&mut self, rollout: &Rollout) -> Result<Vec<(&'static str, f64)>> {
        Ok(self.update(rollout)?.named().to_vec())
    }

    // Includes the replay buffer.
    fn state(&self) -> State {
        let mut state = State::default();
        self.parameters.save(&mut state);
        ADAMS.iter().zip(&self.adams).for_each(|(name, adam)| adam.save(name, &mut state));
        self.replay.save(&mut state);
        state.put_u64("random", &self.random.words());
        state.put_u64("updates", &[self.updates, self.failures]);
        state.put_f64("owed", &[self.owed]);
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        self.parameters.restore(state)?;
        for (name, adam) in ADAMS.iter().zip(&mut self.adams) {
            adam.restore(name, state)?;
        }
        self.replay.restore(state)?;
        self.random = RandomStream::from_words(state.read_u64("random")?);
        [self.updates, self.failures] = state.read_u64("updates")?;
        state.read_f64("owed", std::slice::from_mut(&mut self.owed))
    }
}

impl LearnerOptions for SacConfig {
    fn check(&self) -> Result<()> {
        Self::check(self)
    }

    fn steps_per_rollout(&self) -> usize {
        self.n_steps
    }

    fn discount(&self) -> f32 {
        self.gamma
    }

    fn is_on_policy(&self) -> bool {
        false
    }

    fn learner(&self, setting: &LearnerSetting<'_>) -> Result<Box<dyn Learner>> {
        let own = Self { gamma: setting.discount_of_decision(self.gamma), ..self.clone() };
        let mut sac = Sac::new(setting.widths, setting.environments, own, setting.seed)?;
        sac.set_threads(setting.threads);
        Ok(Box::new(sac))
    }
}
