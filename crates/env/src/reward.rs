//! The reward of a step: the negative sum of a comfort penalty and an energy penalty.

use std::fmt::Debug;

/// The reward of one step, by its terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reward {
    /// Comfort penalty, averaged over the controlled zones; in the paper (1/Z) Σ (T − target)² with τ_T = 1, K².
    pub temperature_penalty: f64,
    /// Energy penalty (w_E / τ_E) E; in the paper E is the HVAC energy of the step, Wh/m².
    pub energy_penalty: f64,
}

impl Reward {
    /// The scalar that an agent maximizes: the negative sum of both penalties.
    pub fn total(self) -> f64 {
        -self.temperature_penalty - self.energy_penalty
    }
}

/// Cost and emissions of the HVAC energy of a step, at the task's prices and factors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expenses {
    /// Currency/m².
    pub cost: f64,
    /// g CO₂/m².
    pub emissions: f64,
}

/// Reward and expenses of a step as numbers: temperature penalty, energy penalty, cost, emissions.
pub type StepNumbers = [f64; 4];

/// Returns reward and expenses as numbers.
pub fn to_numbers(reward: Reward, expenses: Expenses) -> StepNumbers {
    [reward.temperature_penalty, reward.energy_penalty, expenses.cost, expenses.emissions]
}

/// Returns reward and expenses of [`to_numbers`].
#[cfg(target_os = "linux")]
pub fn from_numbers(
    [temperature_penalty, energy_penalty, cost, emissions]: StepNumbers,
) -> (Reward, Expenses) {
    (Reward { temperature_penalty, energy_penalty }, Expenses { cost, emissions })
}

/// The step that a [`RewardFunction`] evaluates.
#[derive(Debug)]
pub struct StepView<'a> {
    /// The controlled zones, in model order.
    pub zones: &'a [ZoneStep],
    /// The observation at the end of the step.
    pub observation: &'a [f64],
    /// The action that was applied, after clamping.
    pub action: &'a [f64],
    /// HVAC electricity of the step, Wh/m².
    pub electricity: f64,
    /// HVAC gas of the step, with other fuels and district energy, Wh/m².
    pub gas: f64,
    /// Energy cost of the step at the task's prices, currency/m².
    pub cost: f64,
    /// Emissions of the step by the task's factors, g CO₂/m².
    pub emissions: f64,
    /// Increase of the episode's peak electric demand in this step, W/m².
    pub peak_rise: f64,
    /// Day of the year on which the step began, from 1.
    pub day_of_year: u32,
    /// Hour of the day at which the step began, from 0.
    pub hour: f64,
}

/// A controlled zone in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneStep {
    /// Air temperature at the end of the step, °C.
    pub temperature: f64,
    /// Target observed before the step, °C.
    pub target: f64,
    /// Whether the zone was occupied when the step began.
    pub occupied: bool,
    /// Whether temperatures above target are penalized.
    pub penalize_above_target: bool,
}

impl ZoneStep {
    /// Penalized deviation from target, K; 0 above target if that is not penalized.
    pub fn deviation(&self) -> f64 {
        let deviation = self.temperature - self.target;
        if self.penalize_above_target { deviation } else { deviation.min(0.0) }
    }
}

/// A user-defined reward: see [`crate::Env::with_reward`].
///
/// ```
/// use b2b_env::{Reward, RewardFunction, StepView};
///
/// /// Penalizes only the coldest zone.
/// #[derive(Debug)]
/// struct Coldest;
///
/// impl RewardFunction for Coldest {
///     fn reward(&mut self, step: &StepView<'_>) -> Reward {
///         let worst = step.zones.iter().map(|zone| zone.target - zone.temperature).fold(0.0, f64::max);
///         Reward { temperature_penalty: worst, energy_penalty: 0.0 }
///     }
/// }
/// ```
pub trait RewardFunction: Debug + Send {
    /// Resets internal state at the start of an episode.
    fn reset(&mut self) {}

    /// Returns the reward of a step. Called on every step: it should not allocate.
    fn reward(&mut self, step: &StepView<'_>) -> Reward;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_is_not_penalized_in_a_zone_without_cooling() {
        let cooled =
            ZoneStep { temperature: 35.0, target: 21.0, occupied: true, penalize_above_target: true };
        assert_eq!(cooled.deviation(), 14.0);
        assert_eq!(ZoneStep { penalize_above_target: false, ..cooled }.deviation(), 0.0);
    }
}
