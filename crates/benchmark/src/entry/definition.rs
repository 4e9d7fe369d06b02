//! A policy entered for a problem.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::entry_policy::EntryPolicy;
use super::violation::violation_of;
use crate::Result;
use crate::problem::{Problem, Stage};
use b2b_evaluate::BuiltIn;
use b2b_evaluate::EpisodePlan;

/// A policy entered for a problem.
#[derive(Debug)]
pub struct Entry {
    /// The problem.
    pub problem: Problem,
    /// Name on the leaderboard.
    pub name: String,
    /// How the policy was made, in one line.
    pub description: Option<String>,
    /// Training steps, as declared by the user.
    pub training_steps: Option<u64>,
    /// The policy.
    pub policy: EntryPolicy,
    /// The policy for training buildings, if the sides have different spaces.
    pub train_policy: Option<EntryPolicy>,
    /// The policies by the number of training steps on each test environment.
    pub adapted: BTreeMap<u64, EntryPolicy>,
    /// The specialists, each trained on its own test building: see [`Stage::UpperBound`].
    pub upper_bound: Option<EntryPolicy>,
}

impl Entry {
    /// Errors unless the protocol of the problem allows the entry.
    ///
    /// # Errors
    /// [`Error::Problem`](b2b_evaluate::Error::Problem) with the violation.
    pub fn check(&self) -> Result<()> {
        self.problem.check()?;
        let protocol = &self.problem.protocol;
        let violation = |why: String| Err(self.problem.error(why).into());
        if let Some(steps) = self.training_steps.filter(|steps| *steps > protocol.training_steps) {
            let budget = protocol.training_steps;
            return violation(format!("{} was trained for {steps} steps; the budget is {budget}", self.name));
        }
        if let Some(steps) = self.adapted.keys().find(|steps| !protocol.adaptation.contains(steps)) {
            let known = &protocol.adaptation;
            return violation(format!("no adaptation test after {steps} steps; expected one of {known:?}"));
        }
        for stage in self.stages() {
            if let Some(why) = violation_of(self.policy_of(stage), &self.problem, stage, self.training_steps)
            {
                return violation(why);
            }
        }
        Ok(())
    }

    /// Returns the stages in order.
    pub fn stages(&self) -> Vec<Stage> {
        let mut stages = vec![Stage::Test];
        if self.problem.protocol.train_sample > 0 {
            stages.push(Stage::Train);
        }
        if !self.adapted.is_empty() {
            stages.push(Stage::Untrained);
            stages.extend(self.adapted.keys().map(|steps| Stage::Adapted(*steps)));
        }
        stages.extend(self.upper_bound.is_some().then_some(Stage::UpperBound));
        stages
    }

    /// Returns the policy of a stage.
    pub fn policy_of(&self, stage: Stage) -> &EntryPolicy {
        static UNTRAINED: LazyLock<EntryPolicy> = LazyLock::new(|| EntryPolicy::BuiltIn(BuiltIn::random()));
        match stage {
            Stage::Test => &self.policy,
            Stage::Train => self.train_policy.as_ref().unwrap_or(&self.policy),
            Stage::Untrained => &UNTRAINED,
            Stage::UpperBound => self.upper_bound.as_ref().unwrap_or(&self.policy),
            Stage::Adapted(steps) => self.adapted.get(&steps).unwrap_or(&self.policy),
        }
    }

    /// Returns the episodes of a stage.
    pub fn episodes(&self, stage: Stage) -> Vec<EpisodePlan> {
        let seeds = self.policy_of(stage).seeds(&self.problem.protocol.seeds);
        self.problem.episodes(stage, &seeds)
    }
}
