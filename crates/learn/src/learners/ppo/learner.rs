//! The state of PPO.

use std::sync::Arc;

use b2b_agent::Interface;
use b2b_agent::network::{Graph, GraphNetwork};

use super::config::PpoConfig;
use super::features::FeatureScale;
use super::networks::{NetworkKind, Networks};
use super::samples::Samples;
use super::scale::ValueScale;
use super::worker::Worker;
use crate::credit::Credit;
use crate::error::{Error, Result};
use crate::nn::Adam;
use crate::policy::{PolicyConfig, RecurrentPolicy};
use crate::random::RandomStream;
use crate::widths::Widths;

/// A learner by proximal policy optimization.
#[derive(Clone, Debug)]
pub struct Ppo {
    pub(super) config: PpoConfig,
    pub(super) widths: Widths,
    pub(super) networks: Networks,
    /// Credit of the rollout's buildings: one for flat networks, one per scene for graph networks.
    pub(super) credits: Vec<Arc<Credit>>,
    /// Number of groups of actions of the largest building.
    pub(super) groups: usize,
    pub(super) parameters: Vec<f32>,
    /// Running average of the parameters.
    pub(super) average: Vec<f32>,
    /// Optimizers of actor and critic.
    pub(super) adams: [Adam; 2],
    /// Factor of the learning rate of the actor.
    pub(super) rate: f64,
    /// Share of the run that is done.
    pub(super) done: f64,
    pub(super) scale: ValueScale,
    pub(super) features: FeatureScale,
    pub(super) random: RandomStream,
    /// Number of updates.
    pub(super) updates: u64,
    /// Number of consecutive updates, up to the last, that skipped steps.
    pub(super) failures: u64,
    pub(super) threads: usize,
    /// Steps of the rollout.
    pub(super) samples: Samples,
    /// Buildings of the scenes of the rollout.
    pub(super) graphs: Vec<Arc<Graph>>,
    pub(super) minibatch: Samples,
    /// Order of the sequences of an epoch.
    pub(super) order: Vec<usize>,
    /// States of a critic with a memory after the last rollout: environments × width.
    pub(super) critic_states: Vec<f32>,
    pub(super) workers: Vec<Worker>,
    pub(super) gradients: Vec<f32>,
}

impl Ppo {
    /// Returns a learner whose initial parameters are drawn with this seed.
    ///
    /// # Errors
    /// When a value of the configuration is outside its range, or its credit has another shape than actions × parts.
    pub fn new(widths: Widths, config: PpoConfig, seed: u64) -> Result<Self> {
        Self::with_networks(
            Networks::new(widths, &config, NetworkKind::Flat),
            FeatureScale::of_slots(widths.observation, config.normalize_observations),
            config,
            seed,
        )
    }

    /// Returns a learner for recurrent networks: actor and critic of the configuration, with a gated recurrent unit
    /// before their last layer. A minibatch has as many whole sequences as fit in `batch_size`, at least one.
    ///
    /// # Errors
    /// Same as [`Ppo::new`], and when a sequence does not divide the steps of a rollout.
    pub fn recurrent(policy: &RecurrentPolicy, widths: Widths, config: PpoConfig, seed: u64) -> Result<Self> {
        policy.check_steps("ppo.n_steps", config.n_steps)?;
        let networks = Networks::new(widths, &config, NetworkKind::Recurrent(policy));
        let features = FeatureScale::of_slots(widths.observation, config.normalize_observations);
        Self::with_networks(networks, features, config, seed)
    }

    /// Returns a learner for graph networks: an actor of this shape, whose outputs are its actions, and a critic of the
    /// same shape with a value per node. With a memory, they learn from sequences of this number of steps. `widths` are
    /// the largest building's. With `normalize`, features have mean 0 and deviation 1 over all nodes of a type.
    ///
    /// # Errors
    /// Same as [`Ppo::new`], and when there is a credit matrix or `normalize_observations`.
    pub fn of_graphs(
        (network, sequence): (&GraphNetwork, usize),
        widths: Widths,
        config: PpoConfig,
        normalize: bool,
        seed: u64,
    ) -> Result<Self> {
        if config.credit.is_some() {
            return Err(Error::config("credit", "a matrix", "graph networks take it from their scenes"));
        }
        if config.normalize_observations {
            let remedy = "graph networks have `policy.normalize`";
            return Err(Error::config("normalize_observations", "true", remedy));
        }
        let networks = Networks::new(widths, &config, NetworkKind::Graph(network, sequence));
        Self::with_networks(networks, FeatureScale::of_nodes(&network.types, normalize), config, seed)
    }

    /// Returns a learner for the networks of a policy.
    ///
    /// # Errors
    /// Same as [`Ppo::recurrent`] and [`Ppo::of_graphs`].
    pub fn of_policy(
        policy: &PolicyConfig,
        interface: Interface,
        widths: Widths,
        config: PpoConfig,
        seed: u64,
    ) -> Result<Self> {
        if let Some(policy) = policy.recurrent() {
            policy.check_steps("ppo.n_steps", config.n_steps)?;
        }
        match policy {
            PolicyConfig::Flat => Self::new(widths, config, seed),
            PolicyConfig::Recurrent(policy) => Self::recurrent(policy, widths, config, seed),
            PolicyConfig::Graph(policy) => {
                let shape = (&policy.network(interface), policy.sequence);
                Self::of_graphs(shape, widths, config, policy.normalize, seed)
            }
        }
    }

    fn with_networks(
        networks: Networks,
        features: FeatureScale,
        config: PpoConfig,
        seed: u64,
    ) -> Result<Self> {
        config.check()?;
        let widths = networks.widths;
        let mut random = RandomStream::new(seed, 0);
        let parameters = networks.initialize(&config, &mut random);
        let credit = Credit::new(config.credit.as_deref(), widths)?;
        Ok(Self {
            groups: if networks.is_by_node() { widths.action } else { credit.groups() },
            credits: vec![Arc::new(credit)],
            adams: [networks.critics().start, networks.critics().len()]
                .map(|size| Adam::new(size, config.adam_epsilon)),
            rate: 1.0,
            done: 0.0,
            scale: ValueScale::new(networks.value_kinds(), config.value_rate),
            gradients: vec![0.0; parameters.len()],
            average: parameters.clone(),
            workers: vec![Worker::new(&networks)],
            threads: 1,
            features,
            samples: Samples::default(),
            graphs: Vec::new(),
            minibatch: Samples::default(),
            order: Vec::new(),
            critic_states: Vec::new(),
            updates: 0,
            failures: 0,
            config,
            widths,
            networks,
            parameters,
            random,
        })
    }

    /// Returns the configuration.
    pub fn config(&self) -> &PpoConfig {
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
