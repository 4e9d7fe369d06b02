//! The controllers that need no file.

use std::fmt;
use std::str::FromStr;

use b2b_control::{
    Constant, Controller, Planner, PlannerParameters, Random, Reactive, ReactiveParameters, Replay,
};
use serde_json::Value;

use super::interface::{EpisodeContext, Policy};
use crate::tuned::controller_parameters;
use crate::{Error, Result};

/// A controller that needs no file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuiltIn {
    /// The reactive controllers: the baseline of every score.
    Reactive,
    /// A uniformly random action at every step.
    Random,
    /// The middle of every actuator's range.
    Constant,
    /// A planner that tries actions on copies of the simulation; takes minutes per simulated day.
    Planner,
}

impl BuiltIn {
    const ALL: [Self; 4] = [Self::Reactive, Self::Random, Self::Constant, Self::Planner];

    /// Returns whether the actions depend on the seed.
    pub fn is_stochastic(self) -> bool {
        matches!(self, Self::Random | Self::Planner)
    }
}

impl fmt::Display for BuiltIn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reactive => "reactive",
            Self::Random => "random",
            Self::Constant => "constant",
            Self::Planner => "planner",
        })
    }
}

impl FromStr for BuiltIn {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|each| each.to_string() == text);
        named.ok_or_else(|| Error::UnknownPolicy { text: text.to_owned() })
    }
}

impl Policy for BuiltIn {
    fn name(&self) -> String {
        self.to_string()
    }

    fn identity(&self) -> String {
        self.to_string()
    }

    fn is_baseline(&self) -> bool {
        *self == Self::Reactive
    }

    fn ignores_interface(&self) -> bool {
        matches!(self, Self::Reactive | Self::Planner)
    }

    fn description(&self, context: &EpisodeContext<'_>) -> Result<Option<Value>> {
        Ok((*self == Self::Reactive).then(|| Reactive::description(&parameters(context))))
    }

    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
        let space = &context.interface.action;
        Ok(match self {
            Self::Reactive => Box::new(reactive(&context)),
            Self::Random => Box::new(Random::new(space, context.seed)),
            Self::Constant => Box::new(Constant::middle(space)),
            Self::Planner => Box::new(plan(context)?),
        })
    }
}

fn reactive(context: &EpisodeContext<'_>) -> Reactive {
    let spaces = context.spaces;
    let steps_per_hour = spaces.episode.steps_per_hour;
    Reactive::new(&spaces.building, &spaces.observation, steps_per_hour, &parameters(context))
}

fn parameters(context: &EpisodeContext<'_>) -> ReactiveParameters {
    controller_parameters(context.subject, context.site, &context.spaces.episode.task)
}

/// Plans the whole episode on copies of it; the plan is replayed afterward.
fn plan(context: EpisodeContext<'_>) -> Result<Replay> {
    let reactive = reactive(&context);
    let EpisodeContext { spaces, seed, episode, .. } = context;
    let mut planner = Planner::new(PlannerParameters::default(), reactive, seed);
    let actions = planner.plan_episode(episode, spaces.episode_steps(), || {})?;
    Ok(Replay::new(actions, spaces.action.len()))
}
