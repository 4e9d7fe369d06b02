//! Built-in controllers, which need no file.

use std::fmt;
use std::str::FromStr;

use b2b_building::Controls;
use b2b_control::{Case, Controller, Kind, KindDescription, baseline, kind};
use b2b_env::{Spaces, Task};
use serde_json::Value;

use super::interface::{EpisodeContext, Policy};
use crate::tuned::controller_parameters;
use crate::{Error, Recorded, Result, SiteInfo, Subject};

/// A controller that needs no file: a [`Kind`] of `b2b_control`.
#[derive(Clone, Copy)]
pub struct BuiltIn(&'static dyn Kind);

impl BuiltIn {
    /// Returns the reactive controllers: the baseline in tasks with targets.
    pub fn reactive() -> Self {
        Self::shipped("reactive")
    }

    /// Returns the sequences of Guideline 36: the baseline in operation tasks.
    pub fn guideline36() -> Self {
        Self::shipped("guideline36")
    }

    /// Returns the baselines of all tasks.
    pub fn baselines() -> [Self; 2] {
        [Self::reactive(), Self::guideline36()]
    }

    /// Returns the baseline that scores under a task are relative to.
    pub fn baseline_of(task: &Task) -> Self {
        Self(baseline(task))
    }

    /// Returns the kind.
    pub(crate) fn kind(self) -> &'static dyn Kind {
        self.0
    }

    /// Returns the controller with uniformly random actions.
    pub fn random() -> Self {
        Self::shipped("random")
    }

    /// Returns the controller that keeps every actuator at the middle of its range.
    pub fn constant() -> Self {
        Self::shipped("constant")
    }

    fn shipped(name: &str) -> Self {
        Self(kind(name).expect("a test finds these kinds"))
    }

    /// Returns whether the actions depend on the seed.
    pub fn is_stochastic(self) -> bool {
        self.0.is_stochastic()
    }

    /// Returns the values of the parameters in an episode.
    fn values(self, subject: &Subject, site: &SiteInfo, spaces: &Spaces) -> Value {
        let task = &spaces.episode.task;
        match self == Self::reactive() {
            // Scores are relative to the parameters for the building's class, wherever its model comes from.
            true => {
                let parameters = controller_parameters(subject, site, task);
                serde_json::to_value(parameters).expect("plain numbers always serialize")
            }
            false => self.0.tuned(&spaces.building, task),
        }
    }

    fn values_in(self, context: &EpisodeContext<'_>) -> Value {
        self.values(context.subject, context.site, context.spaces)
    }

    /// Returns the actions that the controller commands for the observations of a recorded episode, row by row, within
    /// their bounds.
    ///
    /// # Errors
    /// Errors from [`Kind::make`] and [`ActionSpace::clamp_into`](b2b_env::ActionSpace::clamp_into).
    pub fn labels(self, recorded: &Recorded<'_>) -> Result<Vec<f64>> {
        let Recorded { subject, site, spaces, first_observation, trajectory } = recorded;
        let (values, width) = (self.values(subject, site, spaces), spaces.action.len());
        let case = Case { spaces, action: &spaces.action, seed: 0, values: &values };
        let mut controller = self.0.make(&case)?;
        controller.reset();
        let mut labels = vec![0.0; width * trajectory.len()];
        let later = trajectory.observations.chunks_exact(first_observation.len());
        let observations = std::iter::once(*first_observation).chain(later);
        let mut commanded = vec![0.0; width];
        for (row, observation) in labels.chunks_exact_mut(width.max(1)).zip(observations) {
            controller.act(observation, &mut commanded);
            spaces.action.clamp_into(&commanded, row)?;
        }
        Ok(labels)
    }
}

impl fmt::Debug for BuiltIn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BuiltIn({self})")
    }
}

impl PartialEq for BuiltIn {
    fn eq(&self, other: &Self) -> bool {
        self.0.name() == other.0.name()
    }
}

impl Eq for BuiltIn {}

impl fmt::Display for BuiltIn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.name())
    }
}

impl FromStr for BuiltIn {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        kind(text).map(Self).ok_or_else(|| Error::UnknownPolicy { text: text.to_owned() })
    }
}

impl Policy for BuiltIn {
    fn name(&self) -> String {
        self.to_string()
    }

    fn identity(&self) -> String {
        self.0.identity()
    }

    fn is_baseline(&self, task: &Task) -> bool {
        *self == Self::baseline_of(task)
    }

    fn controls(&self) -> Controls {
        self.0.controls()
    }

    fn ignores_interface(&self) -> bool {
        self.0.controls_whole_building()
    }

    fn description(&self, context: &EpisodeContext<'_>) -> Result<Option<Value>> {
        if !self.ignores_interface() || self.0.plans() {
            return Ok(None);
        }
        let (name, seed, values) = (self.name(), context.seed, self.values_in(context));
        Ok(Some(KindDescription { name, seed, values }.to_order()))
    }

    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
        let values = self.values_in(&context);
        let EpisodeContext { spaces, interface, seed, episode, .. } = context;
        let case = Case { spaces, action: &interface.action, seed, values: &values };
        // The whole episode is planned on copies, and the plan is replayed afterward.
        match self.0.plan(&case, episode, &mut || {})? {
            Some(plan) => Ok(plan),
            None => Ok(self.0.make(&case)?),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_named_kinds_exist_and_a_task_of_operation_has_the_guideline_as_its_baseline() {
        let [tracking, operation] =
            ["occupancy+cost1", "operate+tou"].map(|text| text.parse::<Task>().unwrap());
        let baseline_of = |task: &Task| {
            ["reactive", "guideline36", "random", "constant", "own"]
                .into_iter()
                .filter(|name| name.parse::<BuiltIn>().unwrap().is_baseline(task))
                .collect::<Vec<_>>()
        };
        assert_eq!(baseline_of(&tracking), ["reactive"]);
        assert_eq!(baseline_of(&operation), ["guideline36"]);
        assert!(BuiltIn::random().is_stochastic() && !BuiltIn::constant().is_stochastic());
        assert_eq!("planner".parse::<BuiltIn>().unwrap().to_string(), "planner");
    }
}
