//! The traits of a learner.
//!
//! A learner is a folder in [`learners`](crate::learners): its options implement [`LearnerOptions`] and make a
//! [`Learner`]. A training run uses nothing else.

use std::any::Any;
use std::fmt::Debug;

use b2b_agent::Interface;
use b2b_agent::network::Actor;

use crate::error::Result;
use crate::policy::PolicyConfig;
use crate::rollout::Rollout;
use crate::state::State;
use crate::widths::Widths;

/// Improves an actor from rollouts.
pub trait Learner: Send {
    /// Returns the actor that collects the next rollout.
    fn actor(&self) -> Actor;

    /// Returns the actor to evaluate and keep, by default the one that collects rollouts.
    fn averaged_actor(&self) -> Actor {
        self.actor()
    }

    /// Returns the names of the numbers that describe an update.
    fn columns(&self) -> Vec<&'static str>;

    /// Learns from a rollout of the current actor, and returns the numbers that describe the update, by name.
    ///
    /// # Errors
    /// When an array of the rollout has a wrong length, or learning cannot continue.
    fn learn(&mut self, rollout: &Rollout) -> Result<Vec<(&'static str, f64)>>;

    /// Returns the state, from which [`Learner::restore`] continues bit for bit.
    fn state(&self) -> State;

    /// Continues from a state of a learner with the same setting and options.
    ///
    /// # Errors
    /// When the state was saved with other options; the learner is then unusable.
    fn restore(&mut self, state: &State) -> Result<()>;

    /// Sets the share of the run that is done, which schedules follow. Called before every update.
    fn set_done(&mut self, _done: f64) {}

    /// Sets the logarithm of the standard deviation of all actions. Only called if [`Abilities::noise`] allows it.
    fn set_log_std(&mut self, _log_std: f32) {}

    /// Returns the node types seen in rollouts so far, as indices into the graph network's types.
    fn seen_types(&self) -> Vec<usize> {
        Vec::new()
    }
}

/// The options of a kind of learner: a table of a configuration, named as in
/// [`LearnerKind`](crate::learners::LearnerKind).
pub trait LearnerOptions: Any + Debug + Send + Sync {
    /// Checks the values.
    ///
    /// # Errors
    /// When a value is outside its range.
    fn check(&self) -> Result<()>;

    /// Returns the steps of each environment between updates.
    fn steps_per_rollout(&self) -> usize;

    /// Returns the discount γ per step, by default 1. It also applies between the steps of a held decision.
    fn discount(&self) -> f32 {
        1.0
    }

    /// Returns the options of a run that the learner supports, by default none.
    fn abilities(&self) -> Abilities {
        Abilities::default()
    }

    /// Returns whether an update learns from the last rollout alone. Environments then start at different hours, so
    /// that a rollout covers the day.
    fn is_on_policy(&self) -> bool {
        true
    }

    /// Returns a learner with initial parameters.
    ///
    /// # Errors
    /// When the options and the setting are incompatible.
    fn learner(&self, setting: &LearnerSetting<'_>) -> Result<Box<dyn Learner>>;
}

/// Options of a run that a learner supports besides flat networks and rewards in one part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Abilities {
    /// Graph networks.
    pub graphs: bool,
    /// Recurrent networks.
    pub recurrent: bool,
    /// Rewards in parts, with each action credited with the parts it affects.
    pub credit: bool,
    /// Pairs of environments with opposite exploration noise.
    pub mirrored_noise: bool,
    /// Rewards whose weights change between updates: earlier steps are not learned from again.
    pub new_weights: bool,
    /// Initial logarithm of the standard deviation of actions, if a run may set it ([`Learner::set_log_std`]), or why
    /// it may not.
    pub noise: std::result::Result<f32, &'static str>,
}

impl Default for Abilities {
    /// Returns no abilities.
    fn default() -> Self {
        let noise = Err("the learner sets the exploration noise itself");
        Self {
            graphs: false,
            recurrent: false,
            credit: false,
            mirrored_noise: false,
            new_weights: false,
            noise,
        }
    }
}

/// The environments and the agent that a learner is made for.
#[derive(Clone, Debug)]
pub struct LearnerSetting<'a> {
    /// Widths of observations, actions and rewards; for graph networks, the largest building's.
    pub widths: Widths,
    /// Number of environments.
    pub environments: usize,
    /// What the agent observes and how it acts.
    pub interface: Interface,
    /// Kind of network.
    pub policy: &'a PolicyConfig,
    /// Weight of each part of the reward (column) in the advantage of each action (row), for flat networks with credit.
    pub credit: Option<Vec<Vec<f32>>>,
    /// Steps for which a decision is held. A step of a rollout is a decision, discounted by its length.
    pub hold: usize,
    /// Random seed.
    pub seed: u64,
    /// Number of threads. Results do not depend on it.
    pub threads: usize,
}

impl LearnerSetting<'_> {
    /// Returns the discount of a decision, given the discount per step.
    pub fn discount_of_decision(&self, discount: f32) -> f32 {
        (0..self.hold).map(|_| discount).product()
    }
}
