//! Configurations of SAC.

use b2b_agent::network::Activation;
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::limits::{
    check_counts, check_finite, check_not_negative, check_positive, check_shares, check_widths,
};
use crate::nn::RateSchedule;

/// The configuration of SAC. Defaults follow Stable-Baselines3, but learning starts later, and minibatches are larger
/// and fewer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SacConfig {
    /// Learning rate of Adam, for actor, critics and temperature. Default 3e-4.
    pub learning_rate: f64,
    /// Schedule of the learning rate, by rollouts. Default constant.
    pub schedule: RateSchedule,
    /// ε of Adam. Default 1e-8.
    pub adam_epsilon: f32,
    /// Steps per environment to collect for an update. Default 64.
    pub n_steps: usize,
    /// Steps per minibatch. Default 1024.
    pub batch_size: usize,
    /// Minibatches per collected step, over all environments. Default 0.1.
    pub updates_per_step: f64,
    /// Steps in the replay buffer, over all environments, before learning begins. Default 1000.
    pub learning_starts: usize,
    /// Steps that the replay buffer holds, over all environments. Default 1 000 000.
    pub capacity: usize,
    /// Discount γ per step. Default 0.99.
    pub gamma: f32,
    /// Steps of a return before the value of the target critics. Default 1.
    pub return_steps: usize,
    /// τ: share by which the target critics move toward the critics per minibatch. Default 0.005.
    pub tau: f32,
    /// Target entropy of the policy, in units of minus the number of actions. Default 1.
    pub target_entropy_factor: f32,
    /// Initial temperature: the weight of the entropy. Default 1.
    pub initial_temperature: f32,
    /// Whether the temperature is learned (Haarnoja et al. 2018b, eq. 18). Default true.
    pub learn_temperature: bool,
    /// Limit of the norm of gradients of actor and critics. Default none.
    pub max_grad_norm: Option<f32>,
    /// Widths of the hidden layers of the actor. Default 256, 256.
    pub actor_hidden: Vec<usize>,
    /// Widths of the hidden layers of each critic. Default 256, 256.
    pub critic_hidden: Vec<usize>,
    /// Activation of the hidden layers. Default relu.
    pub activation: Activation,
    /// Gain of the last layer of the actor. Default 0.01.
    pub actor_gain: f32,
}

impl Default for SacConfig {
    fn default() -> Self {
        Self {
            learning_rate: 3e-4,
            schedule: RateSchedule::Constant,
            adam_epsilon: 1e-8,
            n_steps: 64,
            batch_size: 1024,
            updates_per_step: 0.1,
            learning_starts: 1000,
            capacity: 1_000_000,
            gamma: 0.99,
            return_steps: 1,
            tau: 0.005,
            target_entropy_factor: 1.0,
            initial_temperature: 1.0,
            learn_temperature: true,
            max_grad_norm: None,
            actor_hidden: vec![256, 256],
            critic_hidden: vec![256, 256],
            activation: Activation::Relu,
            actor_gain: 0.01,
        }
    }
}

impl SacConfig {
    /// Checks the values.
    ///
    /// # Errors
    /// When a value is outside its range.
    pub fn check(&self) -> Result<()> {
        check_positive([
            ("learning_rate", self.learning_rate),
            ("adam_epsilon", f64::from(self.adam_epsilon)),
            ("updates_per_step", self.updates_per_step),
            ("initial_temperature", f64::from(self.initial_temperature)),
            ("max_grad_norm", self.max_grad_norm.map_or(1.0, f64::from)),
        ])?;
        check_not_negative([("actor_gain", f64::from(self.actor_gain))])?;
        check_finite([("target_entropy_factor", f64::from(self.target_entropy_factor))])?;
        check_shares([("gamma", f64::from(self.gamma)), ("tau", f64::from(self.tau))])?;
        check_counts([
            ("n_steps", self.n_steps),
            ("batch_size", self.batch_size),
            ("capacity", self.capacity),
            ("return_steps", self.return_steps),
        ])?;
        check_widths([("actor_hidden", &self.actor_hidden), ("critic_hidden", &self.critic_hidden)])
    }
}
