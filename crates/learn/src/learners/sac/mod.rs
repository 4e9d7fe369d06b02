//! Soft actor-critic (Haarnoja et al. 2018a, "Soft actor-critic"; 2018b, "Soft actor-critic algorithms and applications"), with
//! the details of Stable-Baselines3's `SAC`.
//!
//! An update adds a rollout to the replay buffer ([`replay`]) and learns from minibatches of it. Each has these stages:
//!
//! 1. Critics: returns of several steps, and the value of the target critics after them.
//! 2. Actor: a squashed Gaussian, through the smaller value of the critics ([`loss`]).
//! 3. Temperature, toward a target entropy.
//! 4. Target critics, which follow the critics.
//!
//! Rewards are the sums of their parts.

mod config;
pub mod loss;
mod networks;
pub mod replay;
mod update;
mod worker;

use b2b_agent::network::Actor;

pub use config::SacConfig;
pub use update::Update;

use crate::error::Result;
use crate::nn::Adam;
use crate::random::Random;
use crate::rollout::Widths;
use crate::state::State;
use networks::{Networks, Parameters};
use replay::{Batch, Replay};
use worker::Worker;

/// A learner by soft actor-critic.
#[derive(Clone, Debug)]
pub struct Sac {
    config: SacConfig,
    widths: Widths,
    networks: Networks,
    parameters: Parameters,
    /// Optimizers of actor, critics and temperature.
    adams: [Adam; 3],
    replay: Replay,
    random: Random,
    /// Minibatches that collected steps are worth, and that are not done.
    owed: f64,
    /// Number of updates.
    updates: u64,
    /// Number of the last updates in a row with steps that were skipped.
    failures: u64,
    threads: usize,
    batch: Batch,
    workers: Vec<Worker>,
    /// Gradients of actor and critics.
    gradients: [Vec<f32>; 2],
}

/// Names of the optimizers in a state.
const ADAMS: [&str; 3] = ["adam.actor", "adam.critics", "adam.temperature"];

impl Sac {
    /// Returns a learner with initial parameters of this seed, for rollouts of this number of environments.
    ///
    /// # Errors
    /// When a value of the configuration is outside its range.
    pub fn new(widths: Widths, environments: usize, config: SacConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let networks = Networks::new(widths, &config);
        let mut random = Random::new(seed, 0);
        let parameters = networks.initialize(&config, &mut random);
        let sizes = [parameters.actor.len(), parameters.critics.len(), 1];
        Ok(Self {
            adams: sizes.map(|size| Adam::new(size, config.adam_epsilon)),
            gradients: [vec![0.0; sizes[0]], vec![0.0; sizes[1]]],
            replay: Replay::new(widths, environments, config.capacity),
            workers: vec![Worker::new(&networks)],
            batch: Batch::default(),
            owed: 0.0,
            updates: 0,
            failures: 0,
            threads: 1,
            config,
            widths,
            networks,
            parameters,
            random,
        })
    }

    /// Returns the configuration.
    pub fn config(&self) -> &SacConfig {
        &self.config
    }

    /// Returns the number of updates so far.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Sets the number of threads, by default 1. Results do not depend on it. Two are faster than one only where two cores are idle.
    pub fn set_threads(&mut self, threads: usize) {
        self.threads = threads.max(1);
    }

    /// Returns the actor with the current parameters.
    pub fn actor(&self) -> Actor {
        self.networks.actor(&self.parameters)
    }

    /// Returns the state, from which [`Sac::restore`] continues bit for bit. It has the replay buffer.
    pub fn state(&self) -> State {
        let mut state = State::default();
        self.parameters.save(&mut state);
        ADAMS.iter().zip(&self.adams).for_each(|(name, adam)| adam.save(name, &mut state));
        self.replay.save(&mut state);
        state.put_u64("random", &self.random.words());
        state.put_u64("updates", &[self.updates, self.failures]);
        state.put_f64("owed", &[self.owed]);
        state
    }

    /// Continues from a state of a learner with the same widths, number of environments and configuration.
    ///
    /// # Errors
    /// When the state is of another configuration; the learner is then not usable.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        self.parameters.restore(state)?;
        for (name, adam) in ADAMS.iter().zip(&mut self.adams) {
            adam.restore(name, state)?;
        }
        self.replay.restore(state)?;
        self.random = Random::from_words(state.read_u64("random")?);
        [self.updates, self.failures] = state.read_u64("updates")?;
        state.read_f64("owed", std::slice::from_mut(&mut self.owed))
    }
}

#[cfg(test)]
mod tests;
