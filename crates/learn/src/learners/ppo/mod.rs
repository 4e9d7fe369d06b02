//! Proximal policy optimization (Schulman et al. 2017), with the details of Stable-Baselines3's `PPO`.
//!
//! An update has these stages:
//!
//! 1. Values and log densities of the steps of the rollout, under the parameters that made them.
//! 2. Advantages and returns of each part of the reward, by generalized advantage estimation ([`advantage`]). Each action gets
//!    those of its parts ([`credit`](crate::credit)).
//! 3. Epochs of minibatches: losses ([`loss`]) and gradients, clipped, and a step of Adam.
//!
//! Actions are of a diagonal Gaussian and are not bounded: environments clip them. Actor and critic are separate networks.

pub mod advantage;
mod config;
mod features;
pub mod loss;
mod networks;
mod samples;
mod scale;
mod update;
mod worker;

use std::sync::Arc;

use b2b_agent::network::{Actor, Graph, GraphNetwork};

pub use config::{LogStd, PpoConfig};
pub use update::Update;

use crate::credit::Credit;
use crate::error::{Error, Result};
use crate::nn::Adam;
use crate::random::Random;
use crate::rollout::Widths;
use crate::state::State;
use features::FeatureScale;
use networks::Networks;
use samples::Samples;
use scale::ValueScale;
use worker::Worker;

/// A learner by proximal policy optimization.
#[derive(Clone, Debug)]
pub struct Ppo {
    config: PpoConfig,
    widths: Widths,
    networks: Networks,
    /// Credit of the buildings of the rollout: for flat networks one, for graph networks one for each of its scenes.
    credits: Vec<Arc<Credit>>,
    /// Number of groups of actions of the largest building.
    groups: usize,
    parameters: Vec<f32>,
    /// Running average of the parameters.
    average: Vec<f32>,
    adam: Adam,
    /// Factor of the learning rate of the actor.
    rate: f64,
    scale: ValueScale,
    features: FeatureScale,
    random: Random,
    /// Number of updates.
    updates: u64,
    /// Number of the last updates in a row with steps that were skipped.
    failures: u64,
    threads: usize,
    /// Steps of the rollout and of the minibatch.
    samples: Samples,
    /// Buildings of the scenes of the rollout.
    graphs: Vec<Arc<Graph>>,
    minibatch: Samples,
    order: Vec<usize>,
    workers: Vec<Worker>,
    gradients: Vec<f32>,
}

impl Ppo {
    /// Returns a learner whose initial parameters are drawn with this seed.
    ///
    /// # Errors
    /// When a value of the configuration is outside its range, or its credit has another shape than actions × parts.
    pub fn new(widths: Widths, config: PpoConfig, seed: u64) -> Result<Self> {
        Self::with_networks(Networks::new(widths, &config, None), FeatureScale::new(&[], false), config, seed)
    }

    /// Returns a learner of graph networks: for an actor of this shape, whose outputs are its actions, and a critic alike. `widths`
    /// are those of the largest building. With `normalize`, features have mean 0 and deviation 1 over all nodes of a type.
    ///
    /// # Errors
    /// As [`Ppo::new`]; when there is a credit matrix.
    pub fn of_graphs(
        network: &GraphNetwork,
        widths: Widths,
        config: PpoConfig,
        normalize: bool,
        seed: u64,
    ) -> Result<Self> {
        if config.credit.is_some() {
            return Err(Error::config("credit", "a matrix", "graph networks have that of their scenes"));
        }
        let networks = Networks::new(widths, &config, Some(network));
        Self::with_networks(networks, FeatureScale::new(&network.types, normalize), config, seed)
    }

    fn with_networks(
        networks: Networks,
        features: FeatureScale,
        config: PpoConfig,
        seed: u64,
    ) -> Result<Self> {
        config.check()?;
        let widths = networks.widths;
        let mut random = Random::new(seed, 0);
        let parameters = networks.initialize(&config, &mut random);
        let credit = Credit::new(config.credit.as_deref(), widths)?;
        Ok(Self {
            groups: if networks.is_by_node() { widths.action } else { credit.groups() },
            credits: vec![Arc::new(credit)],
            adam: Adam::new(parameters.len(), config.adam_epsilon),
            rate: 1.0,
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

    /// Sets the number of threads, by default 1. Results do not depend on it. Two are faster than one only where two cores are idle.
    pub fn set_threads(&mut self, threads: usize) {
        self.threads = threads.max(1);
    }

    /// Sets the logarithm of the standard deviation of all actions, where these are free parameters.
    pub fn set_log_std(&mut self, log_std: f32) {
        for parameters in [&mut self.parameters, &mut self.average] {
            parameters[self.networks.log_stds()].fill(log_std);
            self.networks.project(parameters);
        }
    }

    /// Returns the node types seen in rollouts so far, as indices into the graph network's types.
    pub fn seen_types(&self) -> Vec<usize> {
        self.features.seen()
    }

    /// Returns the actor with the current parameters.
    pub fn actor(&self) -> Actor {
        self.networks.actor(&self.parameters)
    }

    /// Returns the actor with the average of the parameters over the last updates: what it has learned, with less of what each
    /// rollout had by chance (Polyak and Juditsky 1992).
    pub fn averaged_actor(&self) -> Actor {
        self.networks.actor(&self.average)
    }

    /// Returns the state, from which [`Ppo::restore`] continues bit for bit.
    pub fn state(&self) -> State {
        let mut state = State::default();
        state.put_f32("parameters", &self.parameters);
        state.put_f32("average", &self.average);
        self.adam.save("adam", &mut state);
        self.scale.save(&mut state);
        self.features.save(&mut state);
        state.put_f64("rate", &[self.rate]);
        state.put_u64("random", &self.random.words());
        state.put_u64("updates", &[self.updates, self.failures]);
        state
    }

    /// Continues from a state of a learner with the same widths and configuration.
    ///
    /// # Errors
    /// When the state is of another configuration; the learner is then not usable.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        state.read_f32("parameters", &mut self.parameters)?;
        state.read_f32("average", &mut self.average)?;
        self.adam.restore("adam", state)?;
        self.scale.restore(state)?;
        self.features.restore(state)?;
        state.read_f64("rate", std::slice::from_mut(&mut self.rate))?;
        self.random = Random::from_words(state.read_u64("random")?);
        [self.updates, self.failures] = state.read_u64("updates")?;
        Ok(())
    }
}

#[cfg(test)]
mod graph_tests;
#[cfg(test)]
mod tests;
