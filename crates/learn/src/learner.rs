//! Learners: what improves an actor, and the options that make one.
//!
//! A learner is a folder in [`learners`](crate::learners): its options implement [`LearnerOptions`], and what they make implements
//! [`Learner`]. A training run knows nothing else of it.

use std::any::Any;
use std::fmt::Debug;

use b2b_agent::Interface;
use b2b_agent::network::Actor;

use crate::error::Result;
use crate::policy::Policy;
use crate::rollout::Rollout;
use crate::state::State;
use crate::widths::Widths;

/// A learner: it reads rollouts and improves an actor.
pub trait Learner: Send {
    /// Returns the actor that collects the next rollout.
    fn actor(&self) -> Actor;

    /// Returns the actor that is evaluated and kept. By default it is that of the rollouts.
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
    /// When the state is of other options; the learner is then not usable.
    fn restore(&mut self, state: &State) -> Result<()>;

    /// Sets the logarithm of the standard deviation of all actions, where a run may: see [`Abilities::noise`].
    fn set_log_std(&mut self, _log_std: f32) {}

    /// Returns the node types seen in rollouts so far, as indices into the graph network's types.
    fn seen_types(&self) -> Vec<usize> {
        Vec::new()
    }
}

/// The options of a kind of learner: a table of a configuration, named as in [`Kind`](crate::learners::Kind).
pub trait LearnerOptions: Any + Debug + Send + Sync {
    /// Checks the values.
    ///
    /// # Errors
    /// When a value is outside its range.
    fn check(&self) -> Result<()>;

    /// Returns the steps of each environment between updates.
    fn steps_per_rollout(&self) -> usize;

    /// Returns which options of a run the learner supports. By default it supports none.
    fn abilities(&self) -> Abilities {
        Abilities::default()
    }

    /// Returns whether an update learns from the last rollout alone. Environments then begin at different hours, so that a rollout
    /// has all of them.
    fn is_on_policy(&self) -> bool {
        true
    }

    /// Returns a learner with initial parameters.
    ///
    /// # Errors
    /// When the options do not go with the setting.
    fn learner(&self, setting: &LearnerSetting<'_>) -> Result<Box<dyn Learner>>;
}

/// What a learner supports besides flat networks and rewards in one part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Abilities {
    /// Graph networks.
    pub graphs: bool,
    /// Rewards in parts, of which each action is credited with those that it affects.
    pub credit: bool,
    /// Pairs of environments with opposite exploration noise.
    pub mirrored_noise: bool,
    /// Initial logarithm of the standard deviation of actions, where a run may set it: see [`Learner::set_log_std`]. Otherwise why
    /// it may not.
    pub noise: std::result::Result<f32, &'static str>,
}

impl Default for Abilities {
    /// Returns those of a learner without any.
    fn default() -> Self {
        let noise = Err("the learner sets the exploration noise itself");
        Self { graphs: false, credit: false, mirrored_noise: false, noise }
    }
}

/// What a learner is made for.
#[derive(Clone, Debug)]
pub struct LearnerSetting<'a> {
    /// Widths of observations, actions and rewards: of graph networks those of the largest building.
    pub widths: Widths,
    /// Number of environments.
    pub environments: usize,
    /// What the agent observes and how it acts.
    pub interface: Interface,
    /// Kind of network.
    pub policy: &'a Policy,
    /// Weight of each part of the reward (column) in the advantage of each action (row), of flat networks with credit.
    pub credit: Option<Vec<Vec<f32>>>,
    /// Random seed.
    pub seed: u64,
    /// Number of threads. Results do not depend on it.
    pub threads: usize,
}
