//! The reward of a step: the negative sum of a comfort penalty and an energy penalty.

pub(crate) mod cost_scale;
pub(crate) mod energy_scale;

use std::fmt::Debug;

use crate::setpoints::band::Pair;
use crate::setpoints::calendar::Season;
use crate::terms::{Amounts, IN_INFO, TERMS, Term};

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

/// Reward and terms of a step as numbers: temperature penalty, energy penalty, and the terms in their order.
pub type StepNumbers = [f64; 2 + TERMS];

/// The numbers of a step in Python's `info`: temperature penalty, energy penalty, and the terms with [`Term::in_info`].
pub type InfoNumbers = [f64; 2 + IN_INFO];

/// Returns reward and terms as numbers.
pub fn to_numbers(reward: Reward, terms: &Amounts) -> StepNumbers {
    numbers(reward, terms.values().iter().copied())
}

/// Returns the numbers for Python's `info`.
pub fn to_info_numbers(reward: Reward, terms: &Amounts) -> InfoNumbers {
    numbers(reward, Term::in_info().map(|(term, _)| terms[term]))
}

fn numbers<const COUNT: usize>(reward: Reward, terms: impl Iterator<Item = f64>) -> [f64; COUNT] {
    let mut numbers = [0.0; COUNT];
    let all = [reward.temperature_penalty, reward.energy_penalty].into_iter().chain(terms);
    numbers.iter_mut().zip(all).for_each(|(number, value)| *number = value);
    numbers
}

/// Returns reward and terms of [`to_numbers`].
pub fn from_numbers(numbers: StepNumbers) -> (Reward, Amounts) {
    let reward = Reward { temperature_penalty: numbers[0], energy_penalty: numbers[1] };
    (reward, Amounts::of(|term| numbers[2 + term as usize]))
}

/// The step that a [`RewardFunction`] evaluates.
#[derive(Debug)]
pub struct StepView<'a> {
    /// The controlled zones, in model order.
    pub zones: &'a [ZoneStep],
    /// The observation at the end of the step.
    pub observation: &'a [f64],
    /// The action that was applied, after clamping, the ventilation interlock and faults.
    pub action: &'a [f64],
    /// Energy, cost, emissions and the other terms of the step: `terms[Term::Cost]`.
    pub terms: Amounts,
    /// Day of the year on which the step began, from 1.
    pub day_of_year: u32,
    /// Hour of the day at which the step began, from 0.
    pub hour: f64,
    /// Season of the site.
    pub(crate) season: Season,
}

/// A controlled zone in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneStep {
    /// Air temperature at the end of the step, °C.
    pub temperature: f64,
    /// Target observed before the step, °C; the middle of the band in a task with bands.
    pub target: f64,
    /// Heating and cooling setpoint observed before the step; both equal the target in a task without bands.
    pub pair: Pair,
    /// Whether the zone was occupied when the step began.
    pub occupied: bool,
    /// Whether temperatures above target are penalized.
    pub penalize_above_target: bool,
    /// Predicted mean vote from the zone's own radiant temperature and humidity, in an operation task with PMV comfort.
    pub vote: Option<f64>,
    /// CO₂ concentration at the end of the step, ppm, in a task with the CO₂ balance.
    pub carbon_dioxide: Option<f64>,
}

impl ZoneStep {
    /// Returns a zone with a target.
    pub const fn with_target(
        temperature: f64,
        target: f64,
        occupied: bool,
        penalize_above_target: bool,
    ) -> Self {
        let pair = Pair { heating: target, cooling: target };
        Self { temperature, target, pair, occupied, penalize_above_target, vote: None, carbon_dioxide: None }
    }

    /// Deviation from the target or from the band, K; negative below.
    pub fn signed_deviation(&self) -> f64 {
        self.pair.deviation(self.temperature)
    }

    /// Penalized deviation, K; 0 above the target where that is not penalized.
    pub fn deviation(&self) -> f64 {
        let deviation = self.signed_deviation();
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
    fn numbers_read_back_as_reward_and_terms() {
        let reward = Reward { temperature_penalty: 0.1, energy_penalty: 0.2 };
        let terms = Amounts::of(|term| term as usize as f64 + 0.5);
        assert_eq!(from_numbers(to_numbers(reward, &terms)), (reward, terms));
        assert_eq!(to_info_numbers(reward, &terms), [0.1, 0.2, terms[Term::Cost], terms[Term::Emissions]]);
    }

    #[test]
    fn heat_is_not_penalized_in_a_zone_without_cooling() {
        let cooled = ZoneStep::with_target(35.0, 21.0, true, true);
        assert_eq!(cooled.deviation(), 14.0);
        assert_eq!(ZoneStep { penalize_above_target: false, ..cooled }.deviation(), 0.0);
    }
}
