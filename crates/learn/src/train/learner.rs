//! The learner of a run.

use b2b_agent::network::Actor;

use super::config::{Algorithm, TrainConfig};
use crate::collector::Widths;
use crate::error::Result;
use crate::ppo::{Ppo, PpoConfig};
use crate::rollout::Rollout;
use crate::state::State;

/// The learner of a run.
pub(super) enum Learner {
    Ppo(Box<Ppo>),
}

impl Learner {
    /// Returns the name of an algorithm.
    pub(super) fn name(algorithm: Algorithm) -> &'static str {
        match algorithm {
            Algorithm::Ppo => "ppo",
        }
    }

    /// Returns the learner of a configuration, with the weights of the parts of a reward in the advantage of each action.
    pub(super) fn new(config: &TrainConfig, widths: Widths, credit: Option<Vec<Vec<f32>>>) -> Result<Self> {
        match config.algorithm {
            Algorithm::Ppo => {
                let ppo = PpoConfig { credit, ..config.ppo.clone() };
                Ok(Self::Ppo(Box::new(Ppo::new(widths, ppo, config.seed)?)))
            }
        }
    }

    pub(super) fn actor(&self) -> Actor {
        match self {
            Self::Ppo(ppo) => ppo.actor(),
        }
    }

    /// Returns the steps of each environment between updates.
    pub(super) fn steps_per_rollout(&self) -> usize {
        match self {
            Self::Ppo(ppo) => ppo.config().n_steps,
        }
    }

    /// Learns from a rollout and returns the numbers that describe the update.
    pub(super) fn update(&mut self, rollout: &Rollout) -> Result<Vec<(&'static str, f64)>> {
        match self {
            Self::Ppo(ppo) => {
                let update = ppo.update(rollout)?;
                Ok(vec![
                    ("policy_loss", update.policy_loss),
                    ("value_loss", update.value_loss),
                    ("entropy", update.entropy),
                    ("approx_kl", update.approx_kl),
                    ("clip_fraction", update.clip_fraction),
                    ("explained_variance", update.explained_variance),
                    ("gradient_norm", update.gradient_norm),
                    ("learning_rate", update.learning_rate),
                    ("epochs", update.epochs as f64),
                    ("skipped", update.skipped as f64),
                ])
            }
        }
    }

    pub(super) fn state(&self) -> State {
        match self {
            Self::Ppo(ppo) => ppo.state(),
        }
    }

    pub(super) fn restore(&mut self, state: &State) -> Result<()> {
        match self {
            Self::Ppo(ppo) => ppo.restore(state),
        }
    }
}
