//! The reward that a task describes.

use super::{Resource, Task};
use crate::calendar::Season;
use crate::reward::{Reward, RewardFunction, StepView};
use crate::task::fuels::Fuels;

/// The task's own reward. An energy scale of `None` counts as 1: [`crate::Env`] fills in that of the building.
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
    /// Returns cost (currency/m²) and emissions (g CO₂/m²) of electricity and gas (Wh/m²) used at an hour of the day.
    pub fn cost_and_emissions(&self, energy: [f64; 2], hour: f64) -> (f64, f64) {
        let at = |fuels: &Fuels| energy[0] * fuels.electricity.at(hour) + energy[1] * fuels.gas.at(hour);
        // Prices are per kWh; kg/kWh is g/Wh.
        (at(&self.prices) / 1000.0, at(&self.emissions))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reward::ZoneStep;

    const COOLED: ZoneStep =
        ZoneStep { temperature: 23.0, target: 21.0, occupied: true, penalize_above_target: true };
    const HEATED: ZoneStep =
        ZoneStep { temperature: 20.0, target: 21.0, occupied: true, penalize_above_target: false };

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
    fn the_reward_matches_the_paper() {
        let mut task = Task { energy_weight: 0.5, energy_scale: Some(2.0), ..Task::default() };
        let reward = task.reward(&view(&[COOLED, HEATED]));
        assert_eq!(reward.temperature_penalty, (4.0 + 1.0) / 2.0);
        assert_eq!(reward.energy_penalty, 0.75);
        assert_eq!(reward.total(), -3.25);
    }

    #[test]
    fn the_energy_term_counts_the_resource_of_the_task() {
        for (resource, expected) in
            [(Resource::Energy, 3.0), (Resource::Cost, 0.5), (Resource::Carbon, 7.0), (Resource::Peak, 4.0)]
        {
            let mut task = Task { resource, energy_weight: 1.0, ..Task::default() };
            assert_eq!(task.reward(&view(&[COOLED])).energy_penalty, expected);
        }
    }

    #[test]
    fn cost_and_emissions_follow_the_fuel_and_the_hour() {
        let (cost, emissions) = Task::default().cost_and_emissions([1000.0, 2000.0], 5.0);
        assert!((cost - (0.127 + 2.0 * 0.0365)).abs() < 1e-12);
        assert!((emissions - (373.0 + 362.0)).abs() < 1e-9);
    }
}
