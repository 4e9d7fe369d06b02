//! The reward of a task.

use b2b_building::{Carrier, CarrierEnergy};

use super::fuels::{EMISSIONS_OF_OTHERS, PRICES_OF_OTHERS};
use super::{Resource, Task};
use crate::calendar::Season;
use crate::reward::{Expenses, Reward, RewardFunction, StepView};

/// The task's own reward. An energy scale of `None` counts as 1; [`crate::Env`] fills in the building's scale.
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
    /// Returns the cost and emissions of energy (Wh/m²) used at an hour of the day.
    pub fn expenses(&self, energy: &CarrierEnergy, hour: f64) -> Expenses {
        let total = |value: &dyn Fn(Carrier) -> f64| {
            Carrier::ALL.into_iter().map(|carrier| energy[carrier as usize] * value(carrier)).sum::<f64>()
        };
        Expenses {
            // Prices are per kWh; kg/kWh is g/Wh.
            cost: total(&|carrier| self.prices.at(carrier, hour, &PRICES_OF_OTHERS)) / 1000.0,
            emissions: total(&|carrier| self.emissions.at(carrier, hour, &EMISSIONS_OF_OTHERS)),
        }
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
    fn expenses_follow_the_carrier_and_the_hour() {
        let used = |amounts: &[(Carrier, f64)]| {
            let mut energy = CarrierEnergy::default();
            amounts.iter().for_each(|(carrier, amount)| energy[*carrier as usize] = *amount);
            energy
        };
        let task: Task = serde_json::from_value(serde_json::json!({"prices": {
            "electricity": (0..24).map(|hour| if hour < 7 { 0.1 } else { 0.2 }).collect::<Vec<_>>(),
            "gas": 0.04,
            "fuel_oil": 0.09,
        }}))
        .unwrap();
        let close = |expenses: Expenses, [cost, emissions]: [f64; 2]| {
            assert!((expenses.cost - cost).abs() < 1e-12, "{expenses:?}, expected a cost of {cost}");
            assert!((expenses.emissions - emissions).abs() < 1e-9, "{expenses:?}, expected {emissions} g");
        };
        let usual = used(&[(Carrier::Electricity, 1000.0), (Carrier::Gas, 2000.0)]);
        close(Task::default().expenses(&usual, 5.0), [0.127 + 2.0 * 0.0365, 373.0 + 362.0]);
        close(task.expenses(&usual, 6.9), [0.1 + 0.08, 373.0 + 362.0]);
        close(task.expenses(&used(&[(Carrier::FuelOil, 1000.0)]), 0.0), [0.09, 252.0]);
        close(task.expenses(&used(&[(Carrier::Propane, 1000.0)]), 0.0), [0.10, 215.0]);
        close(task.expenses(&used(&[(Carrier::DistrictHeating, 800.0)]), 0.0), [0.04, 181.0]);
        close(task.expenses(&used(&[(Carrier::DistrictCooling, 5000.0)]), 7.0), [0.2, 373.0]);
    }
}
