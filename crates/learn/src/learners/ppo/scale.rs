//! Normalization of values (van Hasselt et al. 2016, PopArt).

use std::sync::Arc;

use b2b_agent::network::Layer;

use crate::credit::Credit;
use crate::error::Result;
use crate::state::State;

/// Smallest deviation of returns.
const SMALLEST: f64 = 1e-3;

/// Running mean and deviation of the returns of each kind of part. The critic learns (return - mean) / deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueScale {
    rate: f64,
    updates: u64,
    means: Vec<f64>,
    /// Means of the squares.
    squares: Vec<f64>,
}

impl ValueScale {
    /// Returns a scale for this many kinds of parts. `rate` is the weight of the newest returns.
    pub fn new(kinds: usize, rate: f64) -> Self {
        Self { rate, updates: 0, means: vec![0.0; kinds], squares: vec![1.0; kinds] }
    }

    /// Returns the mean and the deviation of the returns of a kind.
    pub fn of(&self, kind: usize) -> (f64, f64) {
        let variance = self.squares[kind] - self.means[kind] * self.means[kind];
        (self.means[kind], variance.max(0.0).sqrt().max(SMALLEST))
    }

    /// Converts outputs of the critic, rows × parts, to the scale of returns.
    pub fn denormalize(&self, rows: Rows<'_>, values: &mut [f32]) {
        self.map(rows, values, |value, mean, deviation| value * deviation + mean);
    }

    /// Converts returns, rows × parts, to the scale of the critic.
    pub fn normalize(&self, rows: Rows<'_>, returns: &mut [f32]) {
        self.map(rows, returns, |value, mean, deviation| (value - mean) / deviation);
    }

    /// Adds the returns of an update, rows × parts, to the running statistics, and rescales the critic's outputs so
    /// that values stay the same. Does nothing if a return is not finite.
    pub fn update(
        &mut self,
        rows: Rows<'_>,
        returns: &[f32],
        outputs: impl Fn(usize) -> Vec<(Layer, usize)>,
        critic: &mut [f32],
    ) {
        if returns.is_empty() || returns.iter().any(|value| !value.is_finite()) {
            return;
        }
        self.updates += 1;
        let rate = self.rate.max(1.0 / self.updates as f64);
        for (kind, moments) in rows.moments(returns, self.means.len()).into_iter().enumerate() {
            let Some((mean, square)) = moments else { continue };
            let before = self.of(kind);
            self.means[kind] += rate * (mean - self.means[kind]);
            self.squares[kind] += rate * (square - self.squares[kind]);
            let after = self.of(kind);
            outputs(kind).iter().for_each(|(layer, output)| preserve(layer, critic, *output, before, after));
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
    /// When the state does not contain them.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        state.read_f64("values.means", &mut self.means)?;
        state.read_f64("values.squares", &mut self.squares)?;
        [self.updates] = state.read_u64("values.updates")?;
        Ok(())
    }

    fn map(&self, rows: Rows<'_>, values: &mut [f32], change: impl Fn(f32, f32, f32) -> f32) {
        let scales: Vec<(f64, f64)> = (0..self.means.len()).map(|kind| self.of(kind)).collect();
        for (row, credit) in rows.of(values.chunks_exact_mut(rows.parts)) {
            row[credit.parts().len()..].fill(0.0);
            for (value, kind) in row.iter_mut().zip(credit.parts()) {
                *value = kind.map_or(0.0, |kind| {
                    let (mean, deviation) = scales[kind];
                    change(*value, mean as f32, deviation as f32)
                });
            }
        }
    }
}

/// The kinds of the parts in rows of values or returns.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Credits of the buildings.
    pub credits: &'a [Arc<Credit>],
    /// Building of each row.
    pub scenes: &'a [usize],
    /// Width of a row. A building may have fewer parts.
    pub parts: usize,
}

impl<'a> Rows<'a> {
    fn of<T>(self, rows: impl Iterator<Item = T>) -> impl Iterator<Item = (T, &'a Credit)> {
        rows.zip(self.scenes.iter().map(move |scene| &*self.credits[*scene]))
    }

    /// Returns the mean and the mean of squares of each kind; `None` for a kind that no row has.
    fn moments(self, values: &[f32], kinds: usize) -> Vec<Option<(f64, f64)>> {
        let mut sums = vec![(0usize, 0.0, 0.0); kinds];
        for (row, credit) in self.of(values.chunks_exact(self.parts)) {
            for (value, kind) in row.iter().zip(credit.parts()) {
                let Some(kind) = *kind else { continue };
                let (count, sum, squares) = &mut sums[kind];
                let value = f64::from(*value);
                (*count, *sum, *squares) = (*count + 1, *sum + value, *squares + value * value);
            }
        }
        let mean = |(count, sum, squares): (usize, f64, f64)| {
            (count > 0).then(|| (sum / count as f64, squares / count as f64))
        };
        sums.into_iter().map(mean).collect()
    }
}

/// Changes the weights and the bias of an output so that output × deviation + mean stays the same (PopArt, eq. 8 and
/// 9).
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
    use crate::nn::{InitialGains, orthogonal};
    use crate::random::RandomStream;
    use crate::rollout::Widths;

    #[test]
    fn values_stay_as_they_are_when_the_scale_changes() {
        let shape = Mlp::new(2, &[8], 2, Activation::Tanh);
        let mut critic =
            orthogonal(&shape, InitialGains { hidden: 1.0, last: 1.0 }, &mut RandomStream::new(0, 0));
        let layer = shape.layers().last().unwrap();
        let credits = [Arc::new(Credit::joint(Widths { observation: 2, action: 1, parts: 2, nodes: 1 }))];
        let rows = |scenes| Rows { credits: &credits, scenes, parts: 2 };
        let mut scale = ValueScale::new(2, 0.3);
        let value = |critic: &[f32], scale: &ValueScale| {
            let mut output = [0.0; 2];
            shape.forward(critic, &[0.4, -0.7], &mut shape.scratch(), &mut output);
            scale.denormalize(rows(&[0]), &mut output);
            output
        };
        let before = value(&critic, &scale);
        for returns in [[-90.0, 5.0, -110.0, 7.0], [-40.0, 2.0, -70.0, 9.0]] {
            scale.update(rows(&[0, 0]), &returns, |kind| vec![(layer.clone(), kind)], &mut critic);
            let after = value(&critic, &scale);
            assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < 2e-5), "{before:?} {after:?}");
        }
    }

    #[test]
    fn normalized_returns_have_mean_0_and_deviation_1() {
        let shape = Mlp::new(1, &[], 1, Activation::Tanh);
        let (mut scale, mut returns) = (ValueScale::new(1, 0.1), [-12.0, -8.0]);
        let credits = [Arc::new(Credit::joint(Widths { observation: 1, action: 1, parts: 1, nodes: 1 }))];
        let rows = |scenes| Rows { credits: &credits, scenes, parts: 1 };
        let outputs = |kind| vec![(shape.layers().last().unwrap(), kind)];
        scale.update(rows(&[0, 0]), &returns, outputs, &mut [0.0; 2]);
        assert_eq!(scale.of(0), (-10.0, 2.0));
        scale.normalize(rows(&[0, 0]), &mut returns);
        assert_eq!(returns, [-1.0, 1.0]);
        scale.update(rows(&[0]), &[f32::NAN], outputs, &mut [0.0; 2]);
        assert_eq!(scale.of(0), (-10.0, 2.0));
    }
}
