//! A controller with noise on its actions, for datasets of graded quality.

use b2b_env::{ActionSpace, Controller, Decisions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Noise on actions, drawn uniformly for each actuator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Largest deviation, as a share of half of each actuator's range.
    pub level: f64,
    /// Steps for which each draw holds.
    pub steps: u32,
    /// Random seed.
    pub seed: u64,
}

/// Adds [`Noise`] to the actions of another controller, which does not see it, and clamps the sum to the bounds.
pub struct Noisy {
    inner: Box<dyn Controller>,
    noise: Noise,
    low: Vec<f64>,
    high: Vec<f64>,
    random: ChaCha8Rng,
    /// Noise of each actuator, in its unit.
    drawn: Vec<f64>,
    step: u32,
}

impl Noisy {
    /// Adds noise to a controller with this action space.
    pub fn new(inner: Box<dyn Controller>, space: &ActionSpace, noise: Noise) -> Self {
        Self::within(inner, [space.low(), space.high()], noise)
    }

    fn within(inner: Box<dyn Controller>, [low, high]: [&[f64]; 2], noise: Noise) -> Self {
        let random = ChaCha8Rng::seed_from_u64(noise.seed);
        let drawn = vec![0.0; low.len()];
        Self { inner, noise, low: low.to_vec(), high: high.to_vec(), random, drawn, step: 0 }
    }

    fn restart(&mut self) {
        self.random = ChaCha8Rng::seed_from_u64(self.noise.seed);
        self.step = 0;
    }

    fn draw(&mut self) {
        let ranges = self.low.iter().zip(&self.high);
        for (drawn, (low, high)) in self.drawn.iter_mut().zip(ranges) {
            *drawn = self.random.random_range(-1.0..=1.0) * self.noise.level * 0.5 * (high - low);
        }
    }
}

impl Controller for Noisy {
    fn reset(&mut self) {
        self.restart();
        self.inner.reset();
    }

    fn next_episode(&mut self) {
        self.restart();
        self.inner.next_episode();
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        self.inner.act(observation, action);
        if self.step.is_multiple_of(self.noise.steps) {
            self.draw();
        }
        self.step += 1;
        let bounds = self.low.iter().zip(&self.high);
        for ((value, drawn), (low, high)) in action.iter_mut().zip(&self.drawn).zip(bounds) {
            *value = (*value + drawn).clamp(*low, *high);
        }
    }

    fn reward(&mut self, reward: f64) {
        self.inner.reward(reward);
    }

    fn record(&self) -> Option<&Decisions> {
        self.inner.record()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Constant;

    #[test]
    fn noise_is_held_stays_in_its_bounds_and_repeats_with_its_seed() {
        let controller = |level, seed| {
            let inner = Box::new(Constant::new(vec![0.5, 20.0]));
            Noisy::within(inner, [&[0.0, 10.0], &[1.0, 30.0]], Noise { level, steps: 3, seed })
        };
        let run = |mut controller: Noisy| {
            controller.reset();
            let mut act = || {
                let mut action = [0.0; 2];
                controller.act(&[], &mut action);
                action
            };
            (0..300).map(|_| act()).collect::<Vec<_>>()
        };
        let actions = run(controller(0.5, 7));
        assert!(actions.chunks(3).all(|held| held.iter().all(|action| *action == held[0])));
        assert!(actions.chunks(3).zip(actions.chunks(3).skip(1)).all(|(held, next)| held[0] != next[0]));
        let within =
            |[first, second]: &[f64; 2]| (0.25..=0.75).contains(first) && (15.0..=25.0).contains(second);
        assert!(actions.iter().all(within));
        assert!(
            actions.iter().any(|[first, _]| *first < 0.3) && actions.iter().any(|[first, _]| *first > 0.7)
        );
        assert_eq!(actions, run(controller(0.5, 7)));
        assert_ne!(actions, run(controller(0.5, 8)));
        assert!(run(controller(5.0, 7)).iter().all(|[first, _]| (0.0..=1.0).contains(first)));
        assert_eq!(run(controller(0.0, 7)), vec![[0.5, 20.0]; 300]);
    }
}
