//! The networks of SAC and their parameters.

use b2b_agent::network::{Actor, Distribution, Mlp, Shape};

use super::SacConfig;
use crate::error::Result;
use crate::nn::{InitialGains, orthogonal};
use crate::random::RandomStream;
use crate::rollout::Widths;
use crate::state::State;

/// The shapes of actor and critics.
#[derive(Clone, Debug)]
pub(super) struct SacNetworks {
    /// Shape of the actor: outputs are means, then logarithms of standard deviations.
    pub actor: Mlp,
    /// Shape of each critic: inputs are observation, then action; the output is the value.
    pub critic: Mlp,
    /// Number of actions.
    pub actions: usize,
}

/// The parameters of the networks.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    /// Parameters of the actor.
    pub actor: Vec<f32>,
    /// Parameters of both critics, one after the other.
    pub critics: Vec<f32>,
    /// Parameters of both target critics.
    pub targets: Vec<f32>,
    /// Logarithm of the temperature.
    pub log_temperature: f32,
}

impl SacNetworks {
    pub fn new(widths: Widths, config: &SacConfig) -> Self {
        let Widths { observation, action, .. } = widths;
        Self {
            actor: Mlp::new(observation, &config.actor_hidden, 2 * action, config.activation),
            critic: Mlp::new(observation + action, &config.critic_hidden, 1, config.activation),
            actions: action,
        }
    }

    /// Returns initial parameters. Target critics are the critics.
    pub fn initialize(&self, config: &SacConfig, random: &mut RandomStream) -> Parameters {
        let hidden = std::f32::consts::SQRT_2;
        let actor = orthogonal(&self.actor, InitialGains { hidden, last: config.actor_gain }, random);
        let mut critic = || orthogonal(&self.critic, InitialGains { hidden, last: 1.0 }, random);
        let critics = [critic(), critic()].concat();
        let targets = critics.clone();
        Parameters { actor, critics, targets, log_temperature: config.initial_temperature.ln() }
    }

    /// Returns the actor with these parameters.
    pub fn actor(&self, parameters: &Parameters) -> Actor {
        let distribution = Distribution::SquashedGaussian;
        Actor { shape: Shape::Mlp(self.actor.clone()), parameters: parameters.actor.clone(), distribution }
    }
}

impl Parameters {
    /// Moves the target critics a share of the way to the critics.
    pub fn follow(&mut self, share: f32) {
        let pairs = self.targets.iter_mut().zip(&self.critics);
        pairs.for_each(|(target, critic)| *target += share * (critic - *target));
    }

    /// Adds the parameters to a state.
    pub fn save(&self, state: &mut State) {
        state.put_f32("actor", &self.actor);
        state.put_f32("critics", &self.critics);
        state.put_f32("targets", &self.targets);
        state.put_f32("log_temperature", &[self.log_temperature]);
    }

    /// Restores the parameters from a state.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        state.read_f32("actor", &mut self.actor)?;
        state.read_f32("critics", &mut self.critics)?;
        state.read_f32("targets", &mut self.targets)?;
        state.read_f32("log_temperature", std::slice::from_mut(&mut self.log_temperature))
    }
}
