//! How a problem is run, so that two who never met get comparable numbers.

use std::fmt;

use b2b_building::RunPeriod;
use serde::{Deserialize, Serialize};

/// The rules of a problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Steps on training environments, at most, all of them together.
    pub training_steps: u64,
    /// Days of the training environments.
    pub training_period: RunPeriod,
    /// Days of the tests, each an episode.
    pub windows: Vec<RunPeriod>,
    /// Zone time steps an hour.
    pub steps_per_hour: u32,
    /// Seeds: a policy that is trained is trained with each, one that draws draws with each.
    pub seeds: Vec<u64>,
    /// Buildings of the training side that it is tested on as well, to tell the generalisation gap. None at 0.
    pub train_sample: usize,
    /// Numbers of steps on a test environment after which an adapting policy is scored there.
    pub adaptation: Vec<u64>,
    /// Whether the policy is told what building it is in.
    pub attributes: Attributes,
    /// Zeros behind the slots of the observation make it as wide as this, so that all buildings have one shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observation_width: Option<usize>,
}

/// Whether a policy sees the common attributes of a building's morphology (floor area, climate, envelope), behind the
/// observation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Attributes {
    /// It does not.
    #[default]
    Withheld,
    /// It does.
    Given,
}

impl fmt::Display for Attributes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Withheld => "withheld",
            Self::Given => "given",
        })
    }
}

impl Protocol {
    /// What is wrong with it, if anything is.
    pub(super) fn fault(&self) -> Option<String> {
        if self.windows.is_empty() {
            return Some("there is no window to test on: give `windows`".into());
        }
        if self.seeds.is_empty() {
            return Some("there is no seed: give `seeds`".into());
        }
        if let Some(seed) = repeated(&self.seeds) {
            return Some(format!("seed {seed} is given twice"));
        }
        if let Some(window) = repeated(&self.windows) {
            return Some(format!("window {window} is given twice"));
        }
        if self.steps_per_hour == 0 || 60 % self.steps_per_hour != 0 {
            let given = self.steps_per_hour;
            return Some(format!("steps_per_hour is {given}, and 60 minutes are no whole multiple of it"));
        }
        if !self.adaptation.is_sorted_by(|a, b| a < b) || self.adaptation.first() == Some(&0) {
            return Some(format!("adaptation is {:?}: give steps that increase from 1", self.adaptation));
        }
        None
    }
}

fn repeated<T: PartialEq + Copy>(all: &[T]) -> Option<T> {
    all.iter().enumerate().find(|(place, each)| all[..*place].contains(each)).map(|(_, each)| *each)
}
