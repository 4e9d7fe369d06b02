//! Random actions.

use b2b_env::ActionSpace;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::kind::{self, AnyController, Case};
use crate::{Controller, Result};

/// Draws actions uniformly within the bounds, independently at every step. A seed gives the same actions on every
/// machine.
#[derive(Clone, Debug)]
pub struct Random {
    low: Vec<f64>,
    high: Vec<f64>,
    seed: u64,
    random: ChaCha8Rng,
}

impl Random {
    /// Creates a controller that draws actions within the bounds of a space.
    pub fn new(space: &ActionSpace, seed: u64) -> Self {
        Self {
            low: space.low().to_vec(),
            high: space.high().to_vec(),
            seed,
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }
}

impl Controller for Random {
    fn reset(&mut self) {
        self.random = ChaCha8Rng::seed_from_u64(self.seed);
    }

    fn act(&mut self, _observation: &[f64], action: &mut [f64]) {
        for ((value, low), high) in action.iter_mut().zip(&self.low).zip(&self.high) {
            *value = self.random.random_range(*low..=*high);
        }
    }
}

/// The kind `random`.
pub(crate) struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "random"
    }

    fn help(&self) -> &'static str {
        "uniform at every step"
    }

    fn is_stochastic(&self) -> bool {
        true
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        Ok(Box::new(Random::new(case.action, case.seed)))
    }
}
