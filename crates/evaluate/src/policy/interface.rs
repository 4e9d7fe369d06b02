//! The interface of a policy to an episode.

use std::sync::Arc;

use b2b_building::Controls;
use b2b_control::Controller;
use b2b_env::ActionSpace;
use b2b_env::{Spaces, Task};
use b2b_workers::Episode;
use serde_json::Value;

use crate::{Result, SiteInfo, Subject};

/// A policy: makes a controller for an episode of any building, or of buildings of a certain shape.
pub trait Policy: Sync {
    /// Returns the name in results.
    fn name(&self) -> String;

    /// Returns one line with everything the policy's actions depend on besides its observations. Two policies with the
    /// same identity act alike.
    fn identity(&self) -> String;

    /// Returns whether the policy is the baseline that scores under a task are relative to.
    fn is_baseline(&self, _task: &Task) -> bool {
        false
    }

    /// Returns who controls the policy's buildings.
    fn controls(&self) -> Controls {
        Controls::Actuators
    }

    /// Returns whether the policy observes and controls the whole building, regardless of its [`PolicyInterface`].
    fn ignores_interface(&self) -> bool {
        false
    }

    /// Returns the task that the policy was trained for, if it says so.
    fn trained_task(&self) -> Option<&Task> {
        None
    }

    /// Returns the width of the observations that the policy expects, if it is known.
    fn observation_width(&self) -> Option<usize> {
        None
    }

    /// Returns whether its controllers have memory that may outlast an episode: they keep it in
    /// [`Controller::next_episode`].
    fn has_memory(&self) -> bool {
        false
    }

    /// Returns whether one controller runs all episodes with the same building, task and seed, one after another, and
    /// keeps its memory from one to the next, as the protocol of a benchmark problem may say.
    fn keeps_memory(&self) -> bool {
        false
    }

    /// Returns the description from which a worker can create the same controller for a whole building, if possible.
    /// The episode then runs without exchanging every step with the worker.
    ///
    /// # Errors
    /// Same as [`Policy::controller`].
    fn description(&self, _context: &EpisodeContext<'_>) -> Result<Option<Value>> {
        Ok(None)
    }

    /// Makes a controller for one episode, or for a sequence of a policy that keeps its memory. The controller keeps
    /// the state it needs.
    ///
    /// # Errors
    /// Those that [`Evaluation::run`](crate::Evaluation::run) lists end the evaluation; any other error loses the
    /// episode.
    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>>;
}

/// The episode that a policy makes a controller for.
pub struct EpisodeContext<'a> {
    /// The building.
    pub subject: &'a Subject,
    /// Its site.
    pub site: &'a SiteInfo,
    /// Spaces of the environment.
    pub spaces: &'a Arc<Spaces>,
    /// The part of the spaces that the policy observes and controls.
    pub interface: &'a PolicyInterface,
    /// Seed of the episode.
    pub seed: u64,
    /// The episode before its reset: a planner resets it and tries actions on copies of it.
    pub episode: &'a mut Episode,
}

/// What a policy observes and controls: all of an environment's spaces, or a problem's selection from them.
#[derive(Clone, Debug)]
pub struct PolicyInterface {
    /// Names of the values in an observation.
    pub observation: Vec<String>,
    /// Space of the actions.
    pub action: ActionSpace,
}

impl PolicyInterface {
    /// Returns the interface to all of an environment's spaces.
    pub fn of(spaces: &Spaces) -> Self {
        let observation = spaces.observation.slots().iter().map(|slot| slot.name.clone()).collect();
        Self { observation, action: spaces.action.clone() }
    }
}
