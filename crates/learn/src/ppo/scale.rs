//! Normalization of values (van Hasselt et al. 2016, PopArt).

use b2b_agent::network::Layer;

use crate::error::Result;
use crate::state::State;

/// Smallest deviation of returns.
const SMALLEST: f64 = 1e-3;

/// Running mean and deviation of the returns of each part. The critic learns returns minus mean over deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueScale {
    rate: f64,
    updates: u64,
    means: Vec<f64>,
    /// Means of the squares.
    squares: Vec<f64>,
}

impl ValueScale {
    /// Returns the scale of this number of parts. `rate` is the weight of the newest returns.
    pub fn new(parts: usize, rate: f64) -> Self {
        Self { rate, updates: 0, means: vec![0.0; parts], squares: vec![1.0; parts] }
    }

    /// Returns the mean and the deviation of the returns of a part.
    pub fn of(&self, part: usize) -> (f64, f64) {
        let variance = self.squares[part] - self.means[part] * self.means[part];
        (self.means[part], variance.max(0.0).sqrt().max(SMALLEST))
    }

    /// Brings outputs of the critic, rows × parts, to the scale of returns.
    pub fn denormalize(&self, values: &mut [f32]) {
        self.map(values, |value, mean, deviation| value * deviation + mean);
    }

    /// Brings returns, rows × parts, to the scale of the critic.
    pub fn normalize(&self, returns: &mut [f32]) {
        self.map(returns, |value, mean, deviation| (value - mean) / deviation);
    }

    /// Adds the returns of an update, rows × parts, to the running statistics, and changes the last layers of the critic so that its
    /// values, means of their outputs, stay as they are. Returns that are not finite are left out.
    pub fn update(&mut self, returns: &[f32], layers: &[Layer], critic: &mut [f32]) {
        if returns.is_empty() || returns.iter().any(|value| !value.is_finite()) {
            return;
        }
        self.updates += 1;
        let rate = self.rate.max(1.0 / self.updates as f64);
        for part in 0..self.means.len() {
            let before = self.of(part);
            let (mean, square) = moments(returns.iter().skip(part).step_by(self.means.len()));
            self.means[part] += rate * (mean - self.means[part]);
            self.squares[part] += rate * (square - self.squares[part]);
            layers.iter().for_each(|layer| preserve(layer, critic, part, before, self.of(part)));
        }
    }

    /// Adds the statistics to a state.
    pub fn save(&self, state: &mut State) {
        state.put_f64("values.means", &self.means);
        state.put_f64("values.squares", &self.squares);
        state.put_u64("values.updates", &[self.updates]);
    }

    /// Restores the statistics from a state.
    ///
    /// # Errors
    /// When the state does not have it.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        state.read_f64("values.means", &mut self.means)?;
        state.read_f64("values.squares", &mut self.squares)?;
        [self.updates] = state.read_u64("values.updates")?;
        Ok(())
    }

    fn map(&self, values: &mut [f32], change: impl Fn(f32, f32, f32) -> f32) {
        let parts = self.means.len();
        for part in 0..parts {
            let (mean, deviation) = self.of(part);
            for value in values.iter_mut().skip(part).step_by(parts) {
                *value = change(*value, mean as f32, deviation as f32);
            }
        }
    }
}

/// Returns the mean and the mean of squares.
fn moments<'a>(values: impl ExactSizeIterator<Item = &'a f32>) -> (f64, f64) {
    let count = values.len() as f64;
    let add = |(sum, squares), value: &f32| {
        let value = f64::from(*value);
        (sum + value, squares + value * value)
    };
    let (sum, squares) = values.fold((0.0, 0.0), add);
    (sum / count, squares / count)
}

/// Changes the weights and the bias of an output so that output × deviation + mean stays as it is (PopArt, eq. 8 and 9).
fn preserve(layer: &Layer, critic: &mut [f32], output: usize, before: (f64, f64), after: (f64, f64)) {
    let factor = before.1 / after.1;
    for weight in critic[layer.weights.clone()].iter_mut().skip(output).step_by(layer.outputs) {
        *weight = (f64::from(*weight) * factor) as f32;
    }
    let bias = &mut critic[layer.biases.start + output];
    *bias = (f64::from(*bias) * factor + (before.0 - after.0) / after.1) as f32;
}

#[cfg(test)]
mod tests {
    use b2b_agent::network::{Activation, Mlp};

    use super::*;
    use crate::nn::{Gains, orthogonal};
    use crate::random::Random;

    #[test]
    fn values_stay_as_they_are_when_the_scale_changes() {
        let shape = Mlp::new(2, &[8], 2, Activation::Tanh);
        let mut critic = orthogonal(&shape, Gains { hidden: 1.0, last: 1.0 }, &mut Random::new(0, 0));
        let layer = [shape.layers().last().unwrap()];
        let mut scale = ValueScale::new(2, 0.3);
        let value = |critic: &[f32], scale: &ValueScale| {
            let mut output = [0.0; 2];
            shape.forward(critic, &[0.4, -0.7], &mut shape.scratch(), &mut output);
            scale.denormalize(&mut output);
            output
        };
        let before = value(&critic, &scale);
        for returns in [[-90.0, 5.0, -110.0, 7.0], [-40.0, 2.0, -70.0, 9.0]] {
            scale.update(&returns, &layer, &mut critic);
            let after = value(&critic, &scale);
            assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < 2e-5), "{before:?} {after:?}");
        }
    }

    #[test]
    fn normalized_returns_have_mean_0_and_deviation_1() {
        let shape = Mlp::new(1, &[], 1, Activation::Tanh);
        let (mut scale, mut returns) = (ValueScale::new(1, 0.1), [-12.0, -8.0]);
        scale.update(&returns, &[shape.layers().last().unwrap()], &mut [0.0; 2]);
        assert_eq!(scale.of(0), (-10.0, 2.0));
        scale.normalize(&mut returns);
        assert_eq!(returns, [-1.0, 1.0]);
        scale.update(&[f32::NAN], &[shape.layers().last().unwrap()], &mut [0.0; 2]);
        assert_eq!(scale.of(0), (-10.0, 2.0));
    }
}
