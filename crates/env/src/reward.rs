//! The paper's reward (eq. 1): squared temperature deviation and weighted energy, both as penalties.

use b2b_building::{Conditioning, PreparedBuilding};

use crate::task::{HeatingOnlyZones, Task};

/// The reward of one step, by its terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reward {
    /// (1/Z) Σ (T − target)² over the controlled zones, with τ_T = 1; K².
    pub temperature_penalty: f64,
    /// (w_E / τ_E) E, with E the HVAC energy of the step in Wh/m².
    pub energy_penalty: f64,
}

impl Reward {
    /// What an agent maximises: minus both penalties.
    pub fn total(self) -> f64 {
        -self.temperature_penalty - self.energy_penalty
    }
}

/// A controlled zone as the reward sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JudgedZone {
    /// Its slot in the observation.
    pub(crate) slot: usize,
    /// Whether being too warm counts.
    warm_counts: bool,
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

impl JudgedZone {
    /// Deviation from target that counts, K.
    pub(crate) fn deviation(self, temperature: f64, target: f64) -> f64 {
        let deviation = temperature - target;
        if self.warm_counts { deviation } else { deviation.min(0.0) }
    }
}

/// The reward of a step. `energy` in Wh/m².
pub(crate) fn reward(task: &Task, zones: &[JudgedZone], observation: &[f64], energy: f64) -> Reward {
    let squares: f64 =
        zones.iter().map(|zone| zone.deviation(observation[zone.slot], task.target).powi(2)).sum();
    Reward {
        temperature_penalty: squares / zones.len().max(1) as f64,
        energy_penalty: task.energy_weight / task.energy_scale * energy,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: JudgedZone = JudgedZone { slot: 0, warm_counts: true, fully_conditioned: true };
    const HEATED: JudgedZone = JudgedZone { slot: 1, warm_counts: false, fully_conditioned: false };

    #[test]
    fn the_reward_is_the_paper_s() {
        let task = Task { energy_weight: 0.5, energy_scale: 2.0, ..Task::default() };
        let reward = reward(&task, &[BOTH, HEATED], &[23.0, 20.0], 3.0);
        assert_eq!(reward.temperature_penalty, (4.0 + 1.0) / 2.0);
        assert_eq!(reward.energy_penalty, 0.75);
        assert_eq!(reward.total(), -3.25);
    }

    #[test]
    fn a_zone_without_cooling_is_not_blamed_for_summer() {
        assert_eq!(HEATED.deviation(35.0, 21.0), 0.0);
        assert_eq!(BOTH.deviation(35.0, 21.0), 14.0);
    }
}
