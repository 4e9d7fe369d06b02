//! The state of SAC.

use super::config::SacConfig;
use super::networks::{Parameters, SacNetworks};
use super::replay::{ReplayBatch, ReplayBuffer};
use super::worker::SacWorker;
use crate::error::Result;
use crate::nn::Adam;
use crate::random::RandomStream;
use crate::widths::Widths;

/// A learner by soft actor-critic.
#[derive(Clone, Debug)]
pub struct Sac {
    pub(super) config: SacConfig,
    pub(super) widths: Widths,
    pub(super) networks: SacNetworks,
    pub(super) parameters: Parameters,
    /// Optimizers of actor, critics and temperature.
    pub(super) adams: [Adam; 3],
    pub(super) replay: ReplayBuffer,
    pub(super) random: RandomStream,
    /// Minibatches still to do for the steps collected so far.
    pub(super) owed: f64,
    /// Share of the run that is done.
    pub(super) done: f64,
    /// Number of updates.
    pub(super) updates: u64,
    /// Number of consecutive updates, up to the last, that skipped steps.
    pub(super) failures: u64,
    pub(super) threads: usize,
    pub(super) batch: ReplayBatch,
    pub(super) workers: Vec<SacWorker>,
    /// Gradients of actor and critics.
    pub(super) gradients: [Vec<f32>; 2],
}

impl Sac {
    /// Returns a learner with initial parameters drawn from this seed, for rollouts of this number of environments.
    ///
    /// # Errors
    /// When a value of the configuration is outside its range.
    pub fn new(widths: Widths, environments: usize, config: SacConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let networks = SacNetworks::new(widths, &config);
        let mut random = RandomStream::new(seed, 0);
        let parameters = networks.initialize(&config, &mut random);
        let sizes = [parameters.actor.len(), parameters.critics.len(), 1];
        Ok(Self {
            adams: sizes.map(|size| Adam::new(size, config.adam_epsilon)),
            gradients: [vec![0.0; sizes[0]], vec![0.0; sizes[1]]],
            replay: ReplayBuffer::new(widths, environments, config.capacity),
            workers: vec![SacWorker::new(&networks)],
            batch: ReplayBatch::default(),
            owed: 0.0,
            done: 0.0,
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

    /// Sets the number of threads, by default 1. Results do not depend on it. Two are faster than one only where two
    /// cores are idle.
    pub fn set_threads(&mut self, threads: usize) {
        self.threads = threads.max(1);
    }
}
