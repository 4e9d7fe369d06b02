//! PPO as a learner of a training run.

use b2b_agent::network::Actor;

use super::config::{LogStd, PpoConfig};
use super::learner::Ppo;
use super::update::Update;
use crate::error::Result;
use crate::learner::{Abilities, Learner, LearnerOptions, LearnerSetting};
use crate::random::RandomStream;
use crate::rollout::Rollout;
use crate::state::State;

/// Names of the optimizers in the state.
const ADAMS: [&str; 2] = ["adam.actor", "adam.critic"];

impl Learner for Ppo {
    fn set_done(&mut self, done: f64) {
        self.done = done;
    }

    fn set_log_std(&mut self, log_std: f32) {
        for parameters in [&mut self.parameters, &mut self.average] {
            parameters[self.networks.log_stds()].fill(log_std);
            self.networks.project(parameters);
        }
    }

    fn seen_types(&self) -> Vec<usize> {
        self.features.seen()
    }

    fn columns(&self) -> Vec<&'static str> {
        Update::default().named().map(|(name, _)| name).to_vec()
    }

    fn learn(&mut self, rollout: &Rollout) -> Result<Vec<(&'static str, f64)>> {
        Ok(self.update(rollout)?.named().to_vec())
    }

    fn actor(&self) -> Actor {
        self.folded(&self.parameters)
    }

    /// Returns the actor with its parameters averaged over the last updates, which reduces the randomness of single
    /// rollouts (Polyak and Juditsky 1992).
    fn averaged_actor(&self) -> Actor {
        self.folded(&self.average)
    }

    fn state(&self) -> State {
        let mut state = State::default();
        state.put_f32("parameters", &self.parameters);
        state.put_f32("average", &self.average);
        ADAMS.iter().zip(&self.adams).for_each(|(name, adam)| adam.save(name, &mut state));
        self.scale.save(&mut state);
        self.features.save(&mut state);
        state.put_f64("rate", &[self.rate]);
        state.put_u64("random", &self.random.words());
        if self.networks.critic.state() > 0 {
            state.put_f32("critic_states", &self.critic_states);
        }
        state.put_u64("updates", &[self.updates, self.failures]);
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        state.read_f32("parameters", &mut self.parameters)?;
        state.read_f32("average", &mut self.average)?;
        for (name, adam) in ADAMS.iter().zip(&mut self.adams) {
            adam.restore(name, state)?;
        }
        self.scale.restore(state)?;
        self.features.restore(state)?;
        state.read_f64("rate", std::slice::from_mut(&mut self.rate))?;
        self.random = RandomStream::from_words(state.read_u64("random")?);
        if self.networks.critic.state() > 0 {
            self.critic_states = state.values_f32("critic_states")?;
        }
        [self.updates, self.failures] = state.read_u64("updates")?;
        Ok(())
    }
}

impl Ppo {
    /// Returns the actor with these parameters, for observations as they are.
    fn folded(&self, parameters: &[f32]) -> Actor {
        let mut actor = self.networks.actor(parameters);
        if let Some(first) = self.networks.first_layer() {
            self.features.fold(&first, &mut actor.parameters);
        }
        actor
    }
}

impl LearnerOptions for PpoConfig {
    fn check(&self) -> Result<()> {
        Self::check(self)
    }

    fn steps_per_rollout(&self) -> usize {
        self.n_steps
    }

    fn discount(&self) -> f32 {
        self.gamma
    }

    fn abilities(&self) -> Abilities {
        let noise = match self.log_std {
            LogStd::Free => Ok(self.initial_log_std),
            LogStd::OfState => Err("with `ppo.log_std` = of_state, the agent sets the noise"),
        };
        Abilities {
            graphs: true,
            recurrent: true,
            credit: true,
            mirrored_noise: true,
            new_weights: true,
            noise,
        }
    }

    fn learner(&self, setting: &LearnerSetting<'_>) -> Result<Box<dyn Learner>> {
        let LearnerSetting { widths, seed, policy, .. } = *setting;
        let gamma = setting.discount_of_decision(self.gamma);
        // Graph networks take credit from their scenes.
        let credit = setting.credit.clone().filter(|_| !policy.is_graph());
        let own = Self { gamma, credit, ..self.clone() };
        let mut ppo = Ppo::of_policy(policy, setting.interface, widths, own, seed)?;
        ppo.set_threads(setting.threads);
        Ok(Box::new(ppo))
    }
}
