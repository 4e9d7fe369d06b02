//! The learner of a run.

use b2b_agent::network::Actor;
use b2b_building::morphology::NodeType;
use b2b_env::Spaces;

use super::config::{Algorithm, TrainConfig};
use super::policy::Policy;
use crate::credit::credit;
use crate::error::Result;
use crate::ppo::{Ppo, PpoConfig};
use crate::rollout::{Rollout, Widths};
use crate::sac::Sac;
use crate::state::State;

/// The learner of a run.
pub(super) enum Learner {
    Ppo(Box<Ppo>),
    Sac(Box<Sac>),
}

impl Learner {
    /// Returns the name of an algorithm.
    pub(super) fn name(algorithm: Algorithm) -> &'static str {
        match algorithm {
            Algorithm::Ppo => "ppo",
            Algorithm::Sac => "sac",
        }
    }

    /// Returns the learner of a configuration, for buildings with these spaces.
    pub(super) fn new(config: &TrainConfig, widths: Widths, spaces: &Spaces) -> Result<Self> {
        // Results do not depend on it.
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        match config.algorithm {
            Algorithm::Ppo => {
                if let Policy::Graph(policy) = &config.policy {
                    let network = policy.network(config.interface());
                    let (ppo, seed) = (config.ppo.clone(), config.seed);
                    let mut ppo = Ppo::of_graphs(&network, widths, ppo, policy.normalize, seed)?;
                    ppo.set_threads(threads);
                    return Ok(Self::Ppo(Box::new(ppo)));
                }
                let credit = config.credit_by_zone.then(|| credit(spaces));
                let mut ppo = Ppo::new(widths, PpoConfig { credit, ..config.ppo.clone() }, config.seed)?;
                ppo.set_threads(threads);
                Ok(Self::Ppo(Box::new(ppo)))
            }
            Algorithm::Sac => {
                let mut sac = Sac::new(widths, config.environments, config.sac.clone(), config.seed)?;
                sac.set_threads(threads);
                Ok(Self::Sac(Box::new(sac)))
            }
        }
    }

    pub(super) fn actor(&self) -> Actor {
        match self {
            Self::Ppo(ppo) => ppo.actor(),
            Self::Sac(sac) => sac.actor(),
        }
    }

    /// Returns the actor to evaluate and to keep.
    pub(super) fn averaged_actor(&self) -> Actor {
        match self {
            Self::Ppo(ppo) => ppo.averaged_actor(),
            Self::Sac(sac) => sac.actor(),
        }
    }

    /// Returns the names of the node types that rollouts had so far, of graph networks.
    pub(super) fn node_types(&self) -> Vec<String> {
        match self {
            Self::Ppo(ppo) => {
                ppo.seen_types().into_iter().map(|index| NodeType::ALL[index].name().to_owned()).collect()
            }
            Self::Sac(_) => Vec::new(),
        }
    }

    /// Sets the logarithm of the standard deviation of actions, where it is a free parameter.
    pub(super) fn set_log_std(&mut self, log_std: f32) {
        match self {
            Self::Ppo(ppo) => ppo.set_log_std(log_std),
            Self::Sac(_) => {}
        }
    }

    /// Returns the steps of each environment between updates.
    pub(super) fn steps_per_rollout(&self) -> usize {
        match self {
            Self::Ppo(ppo) => ppo.config().n_steps,
            Self::Sac(sac) => sac.config().n_steps,
        }
    }

    /// Returns the names of the numbers that describe an update.
    pub(super) fn names(&self) -> [&'static str; 10] {
        match self {
            Self::Ppo(_) => [
                "policy_loss",
                "value_loss",
                "entropy",
                "approx_kl",
                "clip_fraction",
                "explained_variance",
                "gradient_norm",
                "learning_rate",
                "epochs",
                "skipped",
            ],
            Self::Sac(_) => [
                "critic_loss",
                "actor_loss",
                "temperature",
                "entropy",
                "value",
                "critic_gradient_norm",
                "actor_gradient_norm",
                "learning_rate",
                "minibatches",
                "skipped",
            ],
        }
    }

    /// Learns from a rollout and returns the numbers that describe the update, in the order of their names.
    pub(super) fn update(&mut self, rollout: &Rollout) -> Result<[f64; 10]> {
        match self {
            Self::Ppo(ppo) => {
                let update = ppo.update(rollout)?;
                Ok([
                    update.policy_loss,
                    update.value_loss,
                    update.entropy,
                    update.approx_kl,
                    update.clip_fraction,
                    update.explained_variance,
                    update.gradient_norm,
                    update.learning_rate,
                    update.epochs as f64,
                    update.skipped as f64,
                ])
            }
            Self::Sac(sac) => {
                let update = sac.update(rollout)?;
                Ok([
                    update.critic_loss,
                    update.actor_loss,
                    update.temperature,
                    update.entropy,
                    update.value,
                    update.critic_gradient_norm,
                    update.actor_gradient_norm,
                    update.learning_rate,
                    update.steps as f64,
                    update.skipped as f64,
                ])
            }
        }
    }

    pub(super) fn state(&self) -> State {
        match self {
            Self::Ppo(ppo) => ppo.state(),
            Self::Sac(sac) => sac.state(),
        }
    }

    pub(super) fn restore(&mut self, state: &State) -> Result<()> {
        match self {
            Self::Ppo(ppo) => ppo.restore(state),
            Self::Sac(sac) => sac.restore(state),
        }
    }
}
