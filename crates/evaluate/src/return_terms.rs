//! The sums from which the return of an episode follows for every weight of energy.

use b2b_env::{Metrics, Resource, Task};
use serde::{Deserialize, Serialize};

use crate::scores::Baseline;

/// The sums from which the return of an episode follows for every weight and every resource.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReturnTerms {
    /// Sum of the temperature penalties, K².
    pub temperature_penalty: f64,
    /// HVAC energy, Wh/m².
    pub energy: f64,
    /// Energy cost, currency/m².
    pub cost: f64,
    /// Emissions, g of CO₂/m².
    pub emissions: f64,
    /// Peak electric HVAC demand, W/m².
    pub peak: f64,
}

impl ReturnTerms {
    /// Returns the return under a task's weight and scale; see [`task_for`](crate::task_for) for the scale.
    pub fn episode_return(&self, task: &Task) -> f64 {
        let used = match task.resource {
            Resource::Energy => self.energy,
            Resource::Cost => self.cost,
            Resource::Carbon => self.emissions,
            Resource::Peak => self.peak,
        };
        -self.temperature_penalty - task.energy_weight / task.energy_scale.unwrap_or(1.0) * used
    }

    /// Returns the baseline of these sums under a task's weight and scale.
    pub fn baseline(&self, task: &Task) -> Baseline {
        Baseline { episode_return: self.episode_return(task), energy: self.energy }
    }

    /// Returns all terms in the order of the fields.
    pub fn values(&self) -> [f64; 5] {
        [self.temperature_penalty, self.energy, self.cost, self.emissions, self.peak]
    }
}

impl From<&Metrics> for ReturnTerms {
    fn from(metrics: &Metrics) -> Self {
        Self {
            temperature_penalty: metrics.temperature_penalty,
            energy: metrics.electricity + metrics.gas,
            cost: metrics.cost,
            emissions: metrics.emissions,
            peak: metrics.peak_electricity,
        }
    }
}
