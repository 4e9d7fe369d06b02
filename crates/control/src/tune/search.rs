//! Bayesian optimization by tree-structured Parzen estimators (Bergstra et al. 2011), one per parameter.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tpe::{TpeOptimizer, TpeOptimizerBuilder, parzen_estimator};

use super::space::Axis;
use crate::{Error, Result};

/// Number of first proposals drawn uniformly, before the estimators have enough data.
const UNIFORM: usize = 6;
/// Fraction of the evaluations that counts as good.
const GOOD: f64 = 0.2;

/// A search over a few parameters.
pub(super) struct Search {
    axes: &'static [Axis],
    optimizers: Vec<TpeOptimizer>,
    seed: u64,
    /// Number of scores told.
    told: usize,
}

impl Search {
    pub(super) fn new(axes: &'static [Axis], seed: u64) -> Result<Self> {
        let optimizer = |axis: &Axis| {
            let [low, high] = axis.range();
            let range = tpe::range(low, high).map_err(failed)?;
            TpeOptimizerBuilder::new().gamma(GOOD).build(parzen_estimator(), range).map_err(failed)
        };
        let optimizers = axes.iter().map(optimizer).collect::<Result<_>>()?;
        Ok(Self { axes, optimizers, seed, told: 0 })
    }

    /// Returns the values to evaluate next: a function of the seed and the scores told.
    pub(super) fn propose(&mut self) -> Result<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(self.told as u64);
        let mut values = Vec::with_capacity(self.axes.len());
        for (axis, optimizer) in self.axes.iter().zip(&mut self.optimizers) {
            let [low, high] = axis.range();
            let searched = if self.told < UNIFORM {
                random.random_range(low..high)
            } else {
                optimizer.ask(&mut random).map_err(failed)?
            };
            values.push(axis.to_value(searched));
        }
        Ok(values)
    }

    /// Tells the score of values; higher is better.
    pub(super) fn tell(&mut self, values: &[f64], score: f64) -> Result<()> {
        for ((axis, optimizer), value) in self.axes.iter().zip(&mut self.optimizers).zip(values) {
            let [low, high] = axis.range();
            // The upper end of the range is exclusive.
            let inside = axis.to_search(*value).clamp(low, high.next_down());
            optimizer.tell(inside, -score).map_err(failed)?;
        }
        self.told += 1;
        Ok(())
    }
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::Search(error.to_string())
}
