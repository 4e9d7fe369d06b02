//! Actors: networks that compute actions from observations.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::{Mlp, tanh};

/// Bounds of the logarithm of the standard deviation of a squashed Gaussian. Haarnoja et al. 2018 use -20 and 2; the higher
/// lower bound keeps densities finite in single precision.
pub const LOG_STD: RangeInclusive<f32> = -5.0..=2.0;

/// The distribution of actions, given the outputs of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// A Gaussian whose mean is the output. Samples are not bounded.
    Gaussian {
        /// Logarithm of the standard deviation of each action.
        log_std: Vec<f32>,
    },
    /// A Gaussian whose mean is the first half of the output. The second half is the logarithm of the standard deviation. Samples
    /// are not bounded.
    GaussianOfState {
        /// Lower bound of the logarithm of the standard deviation; the upper bound is that of [`LOG_STD`].
        minimum: f32,
    },
    /// The hyperbolic tangent of a Gaussian with the two halves of the output as mean and logarithm of the standard deviation,
    /// within [`LOG_STD`] (Haarnoja et al. 2018, appendix C). Samples are between -1 and 1.
    SquashedGaussian,
}

/// A network and the distribution of its actions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actor {
    /// Shape of the network.
    pub shape: Mlp,
    /// Parameters of the network.
    pub parameters: Vec<f32>,
    /// Distribution of the actions.
    pub distribution: Distribution,
}

/// Buffers of an actor, reused from step to step.
#[derive(Clone, Debug)]
pub struct Scratch {
    layers: Vec<f32>,
    outputs: Vec<f32>,
}

impl Actor {
    /// Returns the number of inputs.
    pub fn observations(&self) -> usize {
        self.shape.inputs()
    }

    /// Returns the number of actions.
    pub fn actions(&self) -> usize {
        match self.distribution {
            Distribution::Gaussian { .. } => self.shape.outputs(),
            Distribution::GaussianOfState { .. } | Distribution::SquashedGaussian => self.shape.outputs() / 2,
        }
    }

    /// Returns buffers for [`Actor::mean`] and [`Actor::sample`].
    pub fn scratch(&self) -> Scratch {
        Scratch { layers: self.shape.scratch(), outputs: vec![0.0; self.shape.outputs()] }
    }

    /// Writes the action without exploration: the mean, squashed if the distribution is. Allocates nothing.
    ///
    /// # Panics
    /// When a slice has another length than the shape.
    pub fn mean(&self, observation: &[f32], scratch: &mut Scratch, action: &mut [f32]) {
        let Scratch { layers, outputs } = scratch;
        self.shape.forward(&self.parameters, observation, layers, outputs);
        action.copy_from_slice(&outputs[..self.actions()]);
        self.squash(action);
    }

    /// Writes an action of the distribution: mean + standard deviation × normal, squashed if the distribution is. `normals` has a
    /// standard normal number per action. Allocates nothing.
    ///
    /// # Panics
    /// When a slice has another length than the shape.
    pub fn sample(&self, observation: &[f32], normals: &[f32], scratch: &mut Scratch, action: &mut [f32]) {
        assert_eq!(normals.len(), self.actions(), "one normal number per action");
        let Scratch { layers, outputs } = scratch;
        self.shape.forward(&self.parameters, observation, layers, outputs);
        action.copy_from_slice(&outputs[..self.actions()]);
        for (index, (value, normal)) in action.iter_mut().zip(normals).enumerate() {
            *value += self.log_std(index, outputs).exp() * normal;
        }
        self.squash(action);
    }

    fn log_std(&self, action: usize, outputs: &[f32]) -> f32 {
        let of_state = || outputs[self.actions() + action];
        match &self.distribution {
            Distribution::Gaussian { log_std } => log_std[action],
            Distribution::GaussianOfState { minimum } => of_state().clamp(*minimum, *LOG_STD.end()),
            Distribution::SquashedGaussian => of_state().clamp(*LOG_STD.start(), *LOG_STD.end()),
        }
    }

    fn squash(&self, action: &mut [f32]) {
        if self.distribution == Distribution::SquashedGaussian {
            action.iter_mut().for_each(|value| *value = tanh(*value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::Activation;

    /// Returns an actor of one input x without hidden layers: a mean of 2 x and, if it has a second output, -x.
    fn actor(distribution: Distribution) -> Actor {
        let outputs = if matches!(distribution, Distribution::Gaussian { .. }) { 1 } else { 2 };
        let shape = Mlp::new(1, &[], outputs, Activation::Tanh);
        let mut parameters = vec![0.0; shape.parameters()];
        parameters[..outputs].copy_from_slice(&[2.0, -1.0][..outputs]);
        Actor { shape, parameters, distribution }
    }

    fn action(actor: &Actor, x: f32, normal: f32) -> f32 {
        let mut action = [0.0];
        actor.sample(&[x], &[normal], &mut actor.scratch(), &mut action);
        action[0]
    }

    #[test]
    fn a_sample_is_the_mean_plus_deviations() {
        let free = actor(Distribution::Gaussian { log_std: vec![0.5f32.ln()] });
        assert_eq!(action(&free, 1.0, 3.0), 3.5);
        let of_state = actor(Distribution::GaussianOfState { minimum: -1.0 });
        assert_eq!(action(&of_state, 0.5, 2.0), 1.0 + 2.0 * (-0.5f32).exp());
        assert_eq!(action(&of_state, 4.0, 2.0), 8.0 + 2.0 * (-1.0f32).exp());
        let squashed = actor(Distribution::SquashedGaussian);
        assert_eq!(action(&squashed, 0.5, 2.0), tanh(1.0 + 2.0 * (-0.5f32).exp()));
    }

    #[test]
    fn the_mean_is_a_sample_without_noise() {
        for distribution in [Distribution::GaussianOfState { minimum: -1.0 }, Distribution::SquashedGaussian]
        {
            let actor = actor(distribution);
            let mut mean = [0.0];
            actor.mean(&[0.3], &mut actor.scratch(), &mut mean);
            assert_eq!(mean[0], action(&actor, 0.3, 0.0));
        }
    }
}
