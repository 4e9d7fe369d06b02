//! The reward of a task.

use b2b_building::CarrierEnergy;
use b2b_tariff::FuelValues;

use super::Task;
use crate::reward::{Reward, RewardFunction, StepView};

/// The task's own reward. An energy scale of `None` counts as 1; [`crate::Env`] fills in the building's scale.
impl RewardFunction for Task {
    fn reward(&mut self, step: &StepView<'_>) -> Reward {
        let discomfort: f64 = step.zones.iter().map(|zone| self.comfort.penalty(zone, step.season)).sum();
        let used = step.terms[self.resource.term()];
        Reward {
            temperature_penalty: discomfort / step.zones.len().max(1) as f64,
            energy_penalty: self.energy_weight / self.energy_scale.unwrap_or(1.0) * used,
        }
    }
}

impl Task {
    /// Returns the cost of energy (Wh/m²) used at an hour of the day, currency/m².
    pub fn cost(&self, energy: &CarrierEnergy, hour: f64) -> f64 {
        // Prices are per kWh.
        self.prices.times(energy, hour, &FuelValues::PRICES) / 1000.0
    }

    /// Returns the emissions of energy (Wh/m²) used at an hour of the day, g CO₂/m².
    pub fn emissions_of(&self, energy: &CarrierEnergy, hour: f64) -> f64 {
        // kg/kWh is g/Wh.
        self.emissions.times(energy, hour, &FuelValues::EMISSIONS)
    }
}

#[cfg(test)]
mod tests {
    use b2b_building::Carrier;

    use crate::setpoints::calendar::Season;

    use super::*;
    use crate::reward::ZoneStep;
    use crate::terms::{Amounts, Resource, Term};

    const COOLED: ZoneStep = ZoneStep::with_target(23.0, 21.0, true, true);
    const HEATED: ZoneStep = ZoneStep::with_target(20.0, 21.0, true, false);

    fn view(zones: &[ZoneStep]) -> StepView<'_> {
        let mut terms = Amounts::default();
        for (term, value) in
            [(Term::Energy, 3.0), (Term::Cost, 0.5), (Term::Emissions, 7.0), (Term::PeakElectricity, 4.0)]
        {
            terms[term] = value;
        }
        StepView {
            zones,
            observation: &[],
            action: &[],
            terms,
            day_of_year: 1,
            hour: 0.0,
            season: Season::Winter,
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
        for (word, expected) in [("energy", 3.0), ("cost", 0.5), ("carbon", 7.0), ("peak", 4.0)] {
            let resource = Resource::of_word(word).unwrap();
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
        let close = |task: &Task, energy: &CarrierEnergy, hour: f64, [cost, emissions]: [f64; 2]| {
            let (paid, emitted) = (task.cost(energy, hour), task.emissions_of(energy, hour));
            assert!((paid - cost).abs() < 1e-12, "{paid}, expected a cost of {cost}");
            assert!((emitted - emissions).abs() < 1e-9, "{emitted}, expected {emissions} g");
        };
        let usual = used(&[(Carrier::Electricity, 1000.0), (Carrier::Gas, 2000.0)]);
        close(&Task::default(), &usual, 5.0, [0.127 + 2.0 * 0.0365, 373.0 + 362.0]);
        close(&task, &usual, 6.9, [0.1 + 0.08, 373.0 + 362.0]);
        close(&task, &used(&[(Carrier::FuelOil, 1000.0)]), 0.0, [0.09, 252.0]);
        close(&task, &used(&[(Carrier::Propane, 1000.0)]), 0.0, [0.10, 215.0]);
        close(&task, &used(&[(Carrier::DistrictHeating, 800.0)]), 0.0, [0.04, 181.0]);
        close(&task, &used(&[(Carrier::DistrictCooling, 5000.0)]), 7.0, [0.2, 373.0]);
    }
}
