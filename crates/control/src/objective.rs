//! Tuning objectives of the reactive controllers.

use std::fmt;
use std::str::FromStr;

use b2b_env::Task;
use serde::{Deserialize, Serialize};

use crate::Error;

/// The objective of a set of parameters: comfort alone, or comfort and energy.
///
/// Every class of buildings has a tuned set for each objective, and a task chooses between them by its weight of energy
/// (or of cost, emissions or peak demand): the comfort set at a weight of 0, the energy set at any other weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Objective {
    /// Only the temperature penalty.
    Comfort,
    /// The temperature penalty, plus half of the energy relative to τ_E.
    Energy,
}

impl Objective {
    /// Both objectives, in the order in which they are tuned: the energy scale τ_E is measured under the comfort set.
    pub const ALL: [Self; 2] = [Self::Comfort, Self::Energy];

    /// Returns the objective of a task.
    pub fn of(task: &Task) -> Self {
        if task.energy_weight > 0.0 { Self::Energy } else { Self::Comfort }
    }

    /// Returns the energy weight w_E of the objective, as in the paper's tasks.
    pub fn energy_weight(self) -> f64 {
        match self {
            Self::Comfort => 0.0,
            Self::Energy => 0.5,
        }
    }

    /// Returns a task with its energy term replaced by the objective's.
    pub fn task(self, task: &Task) -> Task {
        let Task { energy_scale, resource, .. } = Task::default();
        Task { energy_weight: self.energy_weight(), energy_scale, resource, ..task.clone() }
    }
}

impl fmt::Display for Objective {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Comfort => "comfort",
            Self::Energy => "energy",
        })
    }
}

impl FromStr for Objective {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let named = Self::ALL.into_iter().find(|each| each.to_string() == text);
        named.ok_or_else(|| Error::UnknownObjective { text: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_weight_of_any_resource_selects_the_energy_objective() {
        let of = |text: &str| Objective::of(&text.parse().unwrap());
        assert_eq!(["constant", "occupancy+pmv"].map(of), [Objective::Comfort; 2]);
        assert_eq!(
            ["constant+energy0.5", "random+energy0.01", "constant+cost2", "occupancy+peak1"].map(of),
            [Objective::Energy; 4]
        );
        for objective in Objective::ALL {
            assert_eq!(objective.to_string().parse::<Objective>().unwrap(), objective);
            let task = objective.task(&"random:3+deadband+cost2".parse().unwrap());
            assert_eq!(Objective::of(&task), objective);
        }
        assert!("both".parse::<Objective>().unwrap_err().to_string().contains("comfort or energy"));
    }
}
