//! The cost of actuator travel in rewards.

use b2b_env::{Metrics, Spaces};

use crate::credit::credit;

/// Subtracts the cost of actuator travel from the rewards of an episode.
pub(crate) struct TravelCost {
    /// Share of each part of the reward in the mean travel, for each actuator: actuators × parts.
    shares: Vec<f32>,
    /// Travel of each actuator before the step, full strokes.
    before: Vec<f64>,
}

impl TravelCost {
    /// Returns the cost for a building whose rewards have this number of parts; `places` are the indices of the
    /// controlled zones' and energy's parts. An actuator is charged to its own zone, in equal shares to the zones that
    /// it serves, or to energy if it serves none, so that it is credited with its own travel.
    pub(crate) fn new(spaces: &Spaces, places: &[usize], parts: usize) -> Self {
        let actuators = spaces.action.len();
        let mut shares = vec![0.0; actuators * parts];
        for (row, credits) in shares.chunks_exact_mut(parts).zip(credit(spaces, spaces.action.owners())) {
            let zones = credits.len() - 1;
            let served: f32 = credits[..zones].iter().sum();
            match served > 0.0 {
                true => places
                    .iter()
                    .zip(&credits[..zones])
                    .for_each(|(place, credit)| row[*place] += credit / served),
                false => row[places[zones]] += 1.0,
            }
            row.iter_mut().for_each(|share| *share /= actuators as f32);
        }
        Self { shares, before: vec![0.0; actuators] }
    }

    /// Records the travel before a step.
    pub(crate) fn before_step(&mut self, metrics: &Metrics) {
        self.before.copy_from_slice(&metrics.travel);
    }

    /// Subtracts the cost of the step from the parts of its reward: `cost` for a full stroke, averaged over the
    /// actuators.
    pub(crate) fn subtract(&self, metrics: &Metrics, cost: f32, rewards: &mut [f32]) {
        let strokes = metrics.travel.iter().zip(&self.before).map(|(after, before)| (after - before) as f32);
        for (strokes, shares) in strokes.zip(self.shares.chunks_exact(rewards.len())) {
            rewards.iter_mut().zip(shares).for_each(|(reward, share)| *reward -= cost * share * strokes);
        }
    }
}
