//! Configurations of PPO.

use b2b_agent::network::{Activation, LOG_STD};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::limits::{
    check_counts, check_finite, check_not_negative, check_positive, check_shares, check_widths,
};
use crate::nn::RateSchedule;

/// The parametrization of the standard deviation of actions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogStd {
    /// One free parameter per action.
    #[default]
    Free,
    /// A function of the observation: the second half of the outputs of the actor.
    OfState,
}

/// The configuration of PPO. Defaults follow Stable-Baselines3, except `normalize_values` and `minimum_log_std`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PpoConfig {
    /// Learning rate of Adam. Default 3e-4.
    pub learning_rate: f64,
    /// Schedule of the learning rate. Default constant.
    pub schedule: RateSchedule,
    /// ε of Adam. Default 1e-5.
    pub adam_epsilon: f32,
    /// Steps per environment to collect for an update. Default 2048.
    pub n_steps: usize,
    /// Steps per minibatch. The last minibatch of an epoch has the rest. Default 64.
    pub batch_size: usize,
    /// Passes over the steps of an update. Default 10.
    pub epochs: usize,
    /// Further passes over these steps in which only the critic learns. Default 0.
    pub critic_epochs: usize,
    /// Discount γ per step. Default 0.99.
    pub gamma: f32,
    /// λ of generalized advantage estimation. Default 0.95.
    pub gae_lambda: f32,
    /// ε of the clipped ratio (Schulman et al. 2017, eq. 7). Default 0.2.
    pub clip_range: f32,
    /// Entropy coefficient of the loss. Default 0.
    pub entropy_coefficient: f32,
    /// Coefficient of the squares by which means of actions exceed [-1, 1]: actions beyond are clipped and change
    /// nothing, so that an actor there no longer learns. Default 0.
    pub bound_coefficient: f32,
    /// Coefficient of the value loss. Default 0.5.
    pub value_coefficient: f32,
    /// Maximum norm of the gradient. Default 0.5.
    pub max_grad_norm: f32,
    /// Target KL divergence in nats: an update stops before a minibatch where it exceeds 1.5 times this. Default none.
    pub target_kl: Option<f32>,
    /// Desired divergence of the policy per update, in nats, to which the actor's learning rate adapts: the rate is
    /// divided by 1.5 after an update with more than twice this divergence, and multiplied by 1.5 after an update with
    /// less than half of it, as in rsl_rl (Rudin et al. 2022). The square of the schedule's factor lowers it. Default
    /// none.
    pub desired_kl: Option<f32>,
    /// Whether observations have mean 0 and deviation 1 over all steps so far, as with VecNormalize of
    /// Stable-Baselines3; graph networks have `policy.normalize`. Default false.
    pub normalize_observations: bool,
    /// Whether advantages have mean 0 and deviation 1 in each minibatch. Default true.
    pub normalize_advantage: bool,
    /// Whether advantages have the same deviation in every building of an update, so that buildings where actions change
    /// little count as much as others. Default false.
    pub balance_buildings: bool,
    /// Widths of the hidden layers of the actor. Default 64, 64.
    pub actor_hidden: Vec<usize>,
    /// Widths of the hidden layers of the critic. Default 64, 64.
    pub critic_hidden: Vec<usize>,
    /// Activation of the hidden layers. Default tanh.
    pub activation: Activation,
    /// Parametrization of the standard deviation. Default free parameters.
    pub log_std: LogStd,
    /// Initial logarithm of the standard deviation. Default 0.
    pub initial_log_std: f32,
    /// Lower bound of the logarithm of the standard deviation. Default -5.
    pub minimum_log_std: f32,
    /// Gain of the last layer of the actor. Default 0.01.
    pub actor_gain: f32,
    /// Whether the critic learns returns of mean 0 and deviation 1 (van Hasselt et al. 2016, PopArt). Default true.
    pub normalize_values: bool,
    /// Weight of the returns of the newest update in their running mean and deviation. Default 0.1.
    pub value_rate: f64,
    /// Weight of the newest parameters in the running average, with which agents are saved and evaluated; rollouts use
    /// the newest parameters. The first updates have equal weights. Default 1: no average.
    pub average_rate: f32,
    /// Weight of each part of the reward (column) in the advantage of each action (row). Default none: all actions
    /// share the advantage of the summed parts.
    pub credit: Option<Vec<Vec<f32>>>,
}

impl Default for PpoConfig {
    fn default() -> Self {
        Self {
            learning_rate: 3e-4,
            schedule: RateSchedule::Constant,
            adam_epsilon: 1e-5,
            n_steps: 2048,
            batch_size: 64,
            epochs: 10,
            critic_epochs: 0,
            gamma: 0.99,
            gae_lambda: 0.95,
            clip_range: 0.2,
            entropy_coefficient: 0.0,
            bound_coefficient: 0.0,
            value_coefficient: 0.5,
            max_grad_norm: 0.5,
            target_kl: None,
            desired_kl: None,
            normalize_observations: false,
            normalize_advantage: true,
            balance_buildings: false,
            actor_hidden: vec![64, 64],
            critic_hidden: vec![64, 64],
            activation: Activation::Tanh,
            log_std: LogStd::Free,
            initial_log_std: 0.0,
            minimum_log_std: -5.0,
            actor_gain: 0.01,
            normalize_values: true,
            value_rate: 0.1,
            average_rate: 1.0,
            credit: None,
        }
    }
}

impl PpoConfig {
    /// Checks the values.
    ///
    /// # Errors
    /// When a value is outside its range.
    pub fn check(&self) -> Result<()> {
        check_positive([
            ("learning_rate", self.learning_rate),
            ("adam_epsilon", f64::from(self.adam_epsilon)),
            ("clip_range", f64::from(self.clip_range)),
            ("target_kl", self.target_kl.map_or(1.0, f64::from)),
            ("desired_kl", self.desired_kl.map_or(1.0, f64::from)),
        ])?;
        check_not_negative([
            ("entropy_coefficient", f64::from(self.entropy_coefficient)),
            ("bound_coefficient", f64::from(self.bound_coefficient)),
            ("value_coefficient", f64::from(self.value_coefficient)),
            ("actor_gain", f64::from(self.actor_gain)),
        ])?;
        check_finite([
            ("initial_log_std", f64::from(self.initial_log_std)),
            ("minimum_log_std", f64::from(self.minimum_log_std)),
        ])?;
        check_shares([
            ("gamma", f64::from(self.gamma)),
            ("gae_lambda", f64::from(self.gae_lambda)),
            ("value_rate", self.value_rate),
            ("average_rate", f64::from(self.average_rate)),
        ])?;
        check_counts([("n_steps", self.n_steps), ("batch_size", self.batch_size), ("epochs", self.epochs)])?;
        check_widths([("actor_hidden", &self.actor_hidden), ("critic_hidden", &self.critic_hidden)])?;
        // Infinite: gradients are not clipped.
        if self.max_grad_norm.is_nan() || self.max_grad_norm <= 0.0 {
            return Err(Error::config("max_grad_norm", self.max_grad_norm, "it must be above 0"));
        }
        if self.minimum_log_std > *LOG_STD.end() {
            return Err(Error::config("minimum_log_std", self.minimum_log_std, "it must be at most 2"));
        }
        if !(self.minimum_log_std..=*LOG_STD.end()).contains(&self.initial_log_std) {
            let remedy = "it must be from `minimum_log_std` to 2";
            return Err(Error::config("initial_log_std", self.initial_log_std, remedy));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_have_defaults_and_unknown_ones_are_errors() {
        let config: PpoConfig = serde_json::from_str(r#"{"gamma": 0.9, "schedule": "linear"}"#).unwrap();
        assert_eq!(config, PpoConfig { gamma: 0.9, schedule: RateSchedule::Linear, ..PpoConfig::default() });
        assert!(serde_json::from_str::<PpoConfig>(r#"{"gama": 0.9}"#).is_err());
    }

    #[test]
    fn values_outside_their_range_are_errors() {
        let config = PpoConfig { gamma: 1.5, ..PpoConfig::default() };
        assert_eq!(config.check().unwrap_err().to_string(), "`gamma` is 1.5; it must be from 0 to 1");
        let error = |config: PpoConfig| config.check().unwrap_err().to_string();
        let valid = PpoConfig::default;
        assert!(error(PpoConfig { learning_rate: f64::NAN, ..valid() }).contains("`learning_rate` is NaN"));
        assert!(error(PpoConfig { minimum_log_std: 3.0, ..valid() }).contains("at most 2"));
        assert!(error(PpoConfig { minimum_log_std: f32::NAN, ..valid() }).contains("finite"));
        let below = PpoConfig { initial_log_std: -9.0, ..valid() };
        assert_eq!(error(below), "`initial_log_std` is -9; it must be from `minimum_log_std` to 2");
        assert!(error(PpoConfig { critic_hidden: vec![64, 0], ..valid() }).contains("`critic_hidden` is 0"));
        assert!(error(PpoConfig { value_coefficient: f32::NAN, ..valid() }).contains("value_coefficient"));
        assert!(PpoConfig { max_grad_norm: f32::INFINITY, ..valid() }.check().is_ok());
        assert!(PpoConfig::default().check().is_ok());
    }
}
