//! The search: tree-structured Parzen estimators (Bergstra et al. 2011), one per parameter, and variations of the best
//! set.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tpe::{TpeOptimizer, TpeOptimizerBuilder, parzen_estimator};

use super::space::Axis;
use crate::{Error, Result};

/// Number of first evaluations, after which proposals are no longer drawn uniformly: the estimators have enough data.
pub(super) const UNIFORM: usize = 12;
/// Fraction of the evaluations that counts as good.
const GOOD: f64 = 0.2;
/// Standard deviation of a variation, as a fraction of the range.
const SPREAD: f64 = 0.15;
/// Mean number of parameters that a variation changes, in addition to one that is always changed.
const CHANGED: f64 = 1.5;

/// A search over a few parameters.
pub(super) struct ParameterSearch {
    axes: &'static [Axis],
    optimizers: Vec<TpeOptimizer>,
    seed: u64,
    /// Number of recorded losses.
    told: usize,
}

impl ParameterSearch {
    pub(super) fn new(axes: &'static [Axis], seed: u64) -> Result<Self> {
        let optimizer = |axis: &Axis| {
            let [low, high] = axis.range();
            let range = tpe::range(low, high).map_err(failed)?;
            TpeOptimizerBuilder::new().gamma(GOOD).build(parzen_estimator(), range).map_err(failed)
        };
        let optimizers = axes.iter().map(optimizer).collect::<Result<_>>()?;
        Ok(Self { axes, optimizers, seed, told: 0 })
    }

    /// Returns the values to evaluate next: a function of the seed, the recorded losses and the best values. Proposals
    /// of the estimators and variations of the best values alternate.
    pub(super) fn propose(&mut self, best: Option<&[f64]>) -> Result<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(self.told as u64);
        match best {
            Some(best) if self.told >= UNIFORM && self.told.is_multiple_of(2) => {
                Ok(self.variation(best, &mut random))
            }
            _ => self.estimate(&mut random),
        }
    }

    fn estimate(&mut self, random: &mut ChaCha8Rng) -> Result<Vec<f64>> {
        let mut values = Vec::with_capacity(self.axes.len());
        for (axis, optimizer) in self.axes.iter().zip(&mut self.optimizers) {
            let [low, high] = axis.range();
            let searched = if self.told < UNIFORM {
                random.random_range(low..high)
            } else {
                optimizer.ask(random).map_err(failed)?
            };
            values.push(axis.to_value(searched));
        }
        Ok(values)
    }

    /// Returns the best values with a few of them changed.
    fn variation(&self, best: &[f64], random: &mut ChaCha8Rng) -> Vec<f64> {
        let always = random.random_range(0..self.axes.len());
        let share = CHANGED / self.axes.len() as f64;
        let mut vary = |(index, (axis, value)): (usize, (&Axis, &f64))| {
            if index != always && !random.random_bool(share) {
                return *value;
            }
            let [low, high] = axis.range();
            // The sum of three uniform numbers is nearly normal; its standard deviation is 1/2.
            let normal = 2.0 * ((0..3).map(|_| random.random::<f64>()).sum::<f64>() - 1.5);
            axis.to_value((axis.to_search(*value) + SPREAD * (high - low) * normal).clamp(low, high))
        };
        self.axes.iter().zip(best).enumerate().map(&mut vary).collect()
    }

    /// Records the loss of some values.
    pub(super) fn tell(&mut self, values: &[f64], loss: f64) -> Result<()> {
        for ((axis, optimizer), value) in self.axes.iter().zip(&mut self.optimizers).zip(values) {
            let [low, high] = axis.range();
            // The upper end of the range is exclusive.
            let inside = axis.to_search(*value).clamp(low, high.next_down());
            optimizer.tell(inside, loss).map_err(failed)?;
        }
        self.told += 1;
        Ok(())
    }
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::Search(error.to_string())
}
