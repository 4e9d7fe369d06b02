//! What a step is worth: a penalty for discomfort and one for what is used, added up and turned around.

use std::fmt::Debug;

use b2b_building::{Conditioning, PreparedBuilding};

use crate::setpoints::Season;
use crate::task::{HeatingOnlyZones, Resource, Task};

/// The reward of one step, by its terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reward {
    /// Mean over the controlled zones of what the task's comfort costs; the paper's is (1/Z) Σ (T − target)², with
    /// τ_T = 1; K².
    pub temperature_penalty: f64,
    /// (w_E / τ_E) E; the paper's E is the HVAC energy of the step in Wh/m².
    pub energy_penalty: f64,
}

impl Reward {
    /// What an agent maximises: minus both penalties.
    pub fn total(self) -> f64 {
        -self.temperature_penalty - self.energy_penalty
    }
}

/// What happened in a step, for a reward to judge.
#[derive(Debug)]
pub struct StepView<'a> {
    /// The controlled zones, in model order.
    pub zones: &'a [ZoneStep],
    /// The observation at the end of the step.
    pub observation: &'a [f64],
    /// The action as carried out.
    pub action: &'a [f64],
    /// HVAC electricity of the step, Wh/m².
    pub electricity: f64,
    /// HVAC gas of the step, Wh/m².
    pub gas: f64,
    /// What both cost by the task's prices, currency/m².
    pub cost: f64,
    /// What both emit by the task's factors, g of CO₂/m².
    pub emissions: f64,
    /// By how much the step raised the highest electric HVAC power of the episode, W/m².
    pub peak_rise: f64,
    /// Day of the year on which the step began, from 1.
    pub day_of_year: u32,
    /// Hour at which it began, from 0.
    pub hour: f64,
}

/// A controlled zone in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneStep {
    /// Air temperature at the end of the step, °C.
    pub temperature: f64,
    /// The target that was observed before the step, °C.
    pub target: f64,
    /// Whether it was occupied when the step began.
    pub occupied: bool,
    /// Whether being too warm counts.
    pub warm_counts: bool,
}

impl ZoneStep {
    /// Deviation from target that counts, K.
    pub fn deviation(&self) -> f64 {
        let deviation = self.temperature - self.target;
        if self.warm_counts { deviation } else { deviation.min(0.0) }
    }
}

/// A reward of one's own: see [`crate::Env::with_reward`].
///
/// ```
/// use b2b_env::{Reward, RewardFunction, StepView};
///
/// /// The coldest zone alone.
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
    /// An episode begins.
    fn reset(&mut self) {}

    /// The reward of a step. It must not allocate if steps are not to.
    fn reward(&mut self, step: &StepView<'_>) -> Reward;
}

/// The reward that a task describes. A scale that it leaves open is 1: [`crate::Env`] gives it that of the building.
impl RewardFunction for Task {
    fn reward(&mut self, step: &StepView<'_>) -> Reward {
        let season = Season::of(step.day_of_year);
        let discomfort: f64 = step.zones.iter().map(|zone| self.comfort.penalty(zone, season)).sum();
        let used = match self.resource {
            Resource::Energy => step.electricity + step.gas,
            Resource::Cost => step.cost,
            Resource::Carbon => step.emissions,
            Resource::Peak => step.peak_rise,
        };
        Reward {
            temperature_penalty: discomfort / step.zones.len().max(1) as f64,
            energy_penalty: self.energy_weight / self.energy_scale.unwrap_or(1.0) * used,
        }
    }
}

impl Task {
    /// Cost (currency/m²) and emissions (g of CO₂/m²) of electricity and gas (Wh/m²) used at an hour of the day.
    pub fn cost_and_emissions(&self, energy: [f64; 2], hour: f64) -> (f64, f64) {
        let at = |fuels: &crate::task::Fuels| {
            energy[0] * fuels.electricity.at(hour) + energy[1] * fuels.gas.at(hour)
        };
        // Per kWh, and kg per kWh, which is g per Wh.
        (at(&self.prices) / 1000.0, at(&self.emissions))
    }
}

/// A controlled zone as the reward sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JudgedZone {
    /// Its slot in the observation.
    pub(crate) slot: usize,
    /// Whether being too warm counts.
    pub(crate) warm_counts: bool,
    /// Whether it has both heating and cooling.
    pub(crate) fully_conditioned: bool,
}

/// The controlled zones of a building under a task, by their slot in the observation.
pub(crate) fn judged_zones(building: &PreparedBuilding, task: &Task) -> Vec<JudgedZone> {
    let both_sides = task.heating_only_zones == HeatingOnlyZones::BothSides;
    building
        .zones
        .iter()
        .enumerate()
        .filter(|(_, zone)| zone.conditioning != Conditioning::None)
        .map(|(slot, zone)| {
            let fully_conditioned = zone.conditioning == Conditioning::HeatingAndCooling;
            JudgedZone { slot, warm_counts: fully_conditioned || both_sides, fully_conditioned }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: ZoneStep = ZoneStep { temperature: 23.0, target: 21.0, occupied: true, warm_counts: true };
    const HEATED: ZoneStep = ZoneStep { temperature: 20.0, target: 21.0, occupied: true, warm_counts: false };

    fn view(zones: &[ZoneStep]) -> StepView<'_> {
        StepView {
            zones,
            observation: &[],
            action: &[],
            electricity: 2.0,
            gas: 1.0,
            cost: 0.5,
            emissions: 7.0,
            peak_rise: 4.0,
            day_of_year: 1,
            hour: 0.0,
        }
    }

    #[test]
    fn the_reward_is_the_paper_s() {
        let mut task = Task { energy_weight: 0.5, energy_scale: Some(2.0), ..Task::default() };
        let reward = task.reward(&view(&[BOTH, HEATED]));
        assert_eq!(reward.temperature_penalty, (4.0 + 1.0) / 2.0);
        assert_eq!(reward.energy_penalty, 0.75);
        assert_eq!(reward.total(), -3.25);
    }

    #[test]
    fn a_zone_without_cooling_is_not_blamed_for_summer() {
        assert_eq!(ZoneStep { temperature: 35.0, ..HEATED }.deviation(), 0.0);
        assert_eq!(ZoneStep { temperature: 35.0, ..BOTH }.deviation(), 14.0);
    }

    #[test]
    fn what_is_saved_is_what_the_task_says() {
        for (resource, expected) in
            [(Resource::Energy, 3.0), (Resource::Cost, 0.5), (Resource::Carbon, 7.0), (Resource::Peak, 4.0)]
        {
            let mut task = Task { resource, energy_weight: 1.0, ..Task::default() };
            assert_eq!(task.reward(&view(&[BOTH])).energy_penalty, expected);
        }
    }

    #[test]
    fn cost_and_emissions_follow_the_fuel_and_the_hour() {
        let (cost, emissions) = Task::default().cost_and_emissions([1000.0, 2000.0], 5.0);
        assert!((cost - (0.127 + 2.0 * 0.0365)).abs() < 1e-12);
        assert!((emissions - (373.0 + 362.0)).abs() < 1e-9);
    }
}
