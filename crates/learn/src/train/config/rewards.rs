//! Training rewards.

use serde::{Deserialize, Serialize};

use crate::comfort_weights::ComfortWeights;
use crate::error::Result;
use crate::limits::require;

/// Training rewards. Scores do not depend on them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RewardConfig {
    /// Whether rewards are divided by the baseline's mean penalty in the building, so that a mean reward of -1 is the
    /// baseline's.
    pub scale_rewards: bool,
    /// Cost of a full stroke, averaged over the actuators, in the unit of the training rewards: with `scale_rewards`,
    /// the baseline's mean penalty per step. 0: travel is free.
    pub travel_cost: f32,
    /// Factor by which `travel_cost` grows after every evaluation in which actuators hunt: their travel is above its
    /// limit. 1: it does not grow.
    pub travel_cost_growth: f32,
    /// Whether a reward has a part for every zone and one for energy, and each action is credited with the parts that
    /// it affects.
    pub credit_by_zone: bool,
    /// How fast the weight of discomfort follows the evaluations of training, whose agent acts without noise, until the
    /// discomfort in each evaluated building is the baseline's: the exponent of the ratio of both, 0 to 1. 0: the
    /// weight is the task's.
    pub comfort_rate: f64,
    /// Factor of the task's weight of discomfort before the first evaluation, with a `comfort_rate`.
    pub comfort_weight: f32,
}

impl Default for RewardConfig {
    fn default() -> Self {
        Self {
            scale_rewards: true,
            travel_cost: 0.0,
            travel_cost_growth: 1.0,
            credit_by_zone: false,
            comfort_rate: 0.0,
            comfort_weight: 1.0,
        }
    }
}

impl RewardConfig {
    /// Checks the values.
    pub(super) fn check(&self) -> Result<()> {
        let Self { travel_cost, travel_cost_growth, comfort_rate, comfort_weight, .. } = *self;
        let [low, high] = ComfortWeights::LIMITS;
        require((low..=high).contains(&comfort_weight), || {
            format!("`comfort_weight` is {comfort_weight}; expected {low} to {high}")
        })?;
        require(comfort_weight == 1.0 || comfort_rate > 0.0, || {
            format!("`comfort_weight` is {comfort_weight}, which requires a `comfort_rate` above 0")
        })?;
        require((0.0..=1.0).contains(&comfort_rate), || {
            format!("`comfort_rate` is {comfort_rate}; expected 0 to 1")
        })?;
        require(travel_cost >= 0.0 && travel_cost.is_finite(), || {
            format!("`travel_cost` is {travel_cost}; expected 0 or more")
        })?;
        require(travel_cost_growth >= 1.0 && travel_cost_growth.is_finite(), || {
            format!("`travel_cost_growth` is {travel_cost_growth}; expected 1 or more")
        })
    }
}
