//! The networks of PPO, and where their parameters are.

use std::ops::Range;

use b2b_agent::network::{Actor, Distribution, LOG_STD, Layer, Mlp};

use super::{LogStd, PpoConfig};
use crate::collector::Widths;
use crate::nn::{Gains, orthogonal};
use crate::random::Random;

/// The shapes of actor and critic. All parameters are one slice: those of the actor, the free logarithms of standard deviations,
/// and those of the critic.
#[derive(Clone, Debug)]
pub(super) struct Networks {
    /// Shape of the actor: outputs are means and, if they depend on the observation, logarithms of standard deviations.
    pub actor: Mlp,
    /// Shape of the critic: a value per part of the reward.
    pub critic: Mlp,
    /// Number of actions.
    pub actions: usize,
    /// Lower bound of the logarithm of the standard deviation.
    minimum: f32,
}

impl Networks {
    pub fn new(widths: Widths, config: &PpoConfig) -> Self {
        let outputs = match config.log_std {
            LogStd::Free => widths.action,
            LogStd::OfState => 2 * widths.action,
        };
        Self {
            actor: Mlp::new(widths.observation, &config.actor_hidden, outputs, config.activation),
            critic: Mlp::new(widths.observation, &config.critic_hidden, widths.parts, config.activation),
            actions: widths.action,
            minimum: config.minimum_log_std,
        }
    }

    /// Returns initial parameters.
    pub fn initialize(&self, config: &PpoConfig, random: &mut Random) -> Vec<f32> {
        let hidden = std::f32::consts::SQRT_2;
        let mut parameters = orthogonal(&self.actor, Gains { hidden, last: config.actor_gain }, random);
        if self.of_state() {
            let biases = self.actor.layers().last().map_or(0..0, |layer| layer.biases);
            parameters[biases][self.actions..].fill(config.initial_log_std);
        }
        parameters.extend(self.log_stds().map(|_| config.initial_log_std));
        parameters.extend(orthogonal(&self.critic, Gains { hidden, last: 1.0 }, random));
        self.project(&mut parameters);
        parameters
    }

    /// Returns the place of the parameters of the actor.
    pub fn actors(&self) -> Range<usize> {
        0..self.actor.parameters()
    }

    /// Returns the place of the free logarithms of standard deviations.
    pub fn log_stds(&self) -> Range<usize> {
        let start = self.actor.parameters();
        start..start + if self.of_state() { 0 } else { self.actions }
    }

    /// Returns the place of the parameters of the critic.
    pub fn critics(&self) -> Range<usize> {
        let start = self.log_stds().end;
        start..start + self.critic.parameters()
    }

    /// Returns the last layer of the critic. Its places are those within the parameters of the critic.
    pub fn value_layer(&self) -> Layer {
        self.critic.layers().last().expect("a network has a layer")
    }

    /// Returns the actor with these parameters.
    pub fn actor(&self, parameters: &[f32]) -> Actor {
        let distribution = match self.of_state() {
            true => Distribution::GaussianOfState { minimum: self.minimum },
            false => Distribution::Gaussian { log_std: parameters[self.log_stds()].to_vec() },
        };
        Actor { shape: self.actor.clone(), parameters: parameters[self.actors()].to_vec(), distribution }
    }

    /// Returns whether standard deviations depend on the observation.
    pub fn of_state(&self) -> bool {
        self.actor.outputs() > self.actions
    }

    /// Writes the logarithms of standard deviations for the outputs of the actor.
    pub fn write_log_std(&self, parameters: &[f32], outputs: &[f32], log_std: &mut [f32]) {
        match self.of_state() {
            true => log_std.copy_from_slice(&outputs[self.actions..]),
            false => log_std.copy_from_slice(&parameters[self.log_stds()]),
        }
        log_std.iter_mut().for_each(|value| *value = value.clamp(self.minimum, *LOG_STD.end()));
    }

    /// Sets gradients to 0 where the logarithm of the standard deviation of these outputs is at a bound.
    pub fn clamp_gradients(&self, outputs: &[f32], gradients: &mut [f32]) {
        let range = self.minimum..=*LOG_STD.end();
        for (output, gradient) in outputs[self.actions..].iter().zip(gradients) {
            if !range.contains(output) {
                *gradient = 0.0;
            }
        }
    }

    /// Brings free logarithms of standard deviations within their bounds.
    pub fn project(&self, parameters: &mut [f32]) {
        let (minimum, maximum) = (self.minimum, *LOG_STD.end());
        parameters[self.log_stds()].iter_mut().for_each(|value| *value = value.clamp(minimum, maximum));
    }
}
