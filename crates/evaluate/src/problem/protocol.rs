//! The protocol of a problem, which makes results of different users comparable.

use std::fmt;
use std::str::FromStr;

use b2b_building::{Period, RunPeriod};
use serde::{Deserialize, Serialize};

use crate::HouseForm;

/// The protocol of a problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Training budget: steps over all training environments.
    pub training_steps: u64,
    /// Run period of the training environments.
    pub training_period: RunPeriod,
    /// Run periods of the tests, one episode each.
    pub windows: Vec<Period>,
    /// How long a policy with memory keeps it.
    #[serde(default, skip_serializing_if = "Memory::is_of_episode")]
    pub memory: Memory,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Seeds of training, and of stochastic policies.
    pub seeds: Vec<u64>,
    /// Number of training buildings that the policy is also tested on, for the generalization gap.
    pub train_sample: usize,
    /// Numbers of training steps on a test environment after which an adapting policy is scored on it.
    pub adaptation: Vec<u64>,
    /// Whether observations include the building's attributes.
    pub attributes: Attributes,
    /// Form of the observations of houses.
    #[serde(default, skip_serializing_if = "HouseForm::is_roles")]
    pub observation: HouseForm,
    /// Width to which observations in model order are zero-padded, so that all buildings have one shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observation_width: Option<usize>,
}

/// Whether the common attributes of a building's morphology (floor area, climate, envelope), scaled to [-1, 1], follow
/// the observation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Attributes {
    /// They do not.
    #[default]
    Withheld,
    /// They do.
    Given,
}

/// How long a policy with memory, such as a recurrent network, keeps it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Memory {
    /// For an episode.
    #[default]
    Episode,
    /// In each building, task and seed over all run periods of the test, which are then consecutive episodes of one
    /// controller. No weights change, and a policy without memory sees no difference.
    Building,
}

impl Memory {
    fn is_of_episode(&self) -> bool {
        *self == Self::Episode
    }
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Episode => "episode",
            Self::Building => "building",
        })
    }
}

impl FromStr for Memory {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "episode" => Ok(Self::Episode),
            "building" => Ok(Self::Building),
            _ => Err(format!("unknown value `{text}`; expected episode or building")),
        }
    }
}

impl fmt::Display for Attributes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Withheld => "withheld",
            Self::Given => "given",
        })
    }
}

impl FromStr for Attributes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "withheld" => Ok(Self::Withheld),
            "given" => Ok(Self::Given),
            _ => Err(format!("unknown value `{text}`; expected given or withheld")),
        }
    }
}

impl Protocol {
    /// Returns the run periods over which policies keep their memory, one episode after another; none without such
    /// memory.
    pub fn consecutive(&self) -> &[Period] {
        match self.memory {
            Memory::Building => &self.windows,
            Memory::Episode => &[],
        }
    }

    /// Returns the fault of the protocol, if it has one.
    pub(super) fn fault(&self) -> Option<String> {
        if self.windows.is_empty() {
            return Some("`windows` is empty; list at least one run period".into());
        }
        if self.seeds.is_empty() {
            return Some("`seeds` is empty; list at least one seed".into());
        }
        if let Some(seed) = repeated(&self.seeds) {
            return Some(format!("seed {seed} is listed twice"));
        }
        if let Some(window) = repeated(&self.windows) {
            return Some(format!("window {window} is listed twice"));
        }
        if let Some(pair) = self.consecutive().windows(2).find(|pair| !is_before(pair[0], pair[1])) {
            return Some(format!(
                "policies keep their memory over the windows, but {} does not end before {}; list days of one year in order",
                pair[0], pair[1]
            ));
        }
        if self.steps_per_hour == 0 || 60 % self.steps_per_hour != 0 {
            let given = self.steps_per_hour;
            return Some(format!("steps_per_hour is {given}; expected a divisor of 60"));
        }
        if !self.adaptation.is_sorted_by(|a, b| a < b) || self.adaptation.first() == Some(&0) {
            return Some(format!(
                "adaptation is {:?}; expected increasing numbers of steps from 1 on",
                self.adaptation
            ));
        }
        None
    }
}

/// Returns whether a run period ends before another begins in the same year.
fn is_before(earlier: Period, later: Period) -> bool {
    match (earlier, later) {
        (Period::Days(earlier), Period::Days(later)) => {
            earlier.first() <= earlier.last() && earlier.last() < later.first()
        }
        _ => false,
    }
}

fn repeated<T: PartialEq + Copy>(all: &[T]) -> Option<T> {
    all.iter().enumerate().find(|(place, each)| all[..*place].contains(each)).map(|(_, each)| *each)
}
