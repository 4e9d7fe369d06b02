//! The Adam optimizer and gradient clipping.

use crate::error::Result;
use crate::state::State;

/// Decay of the mean of gradients.
const FIRST: f32 = 0.9;
/// Decay of the mean of squared gradients.
const SECOND: f32 = 0.999;

/// Adam (Kingma and Ba 2015, algorithm 1), with decays 0.9 and 0.999.
#[derive(Clone, Debug)]
pub struct Adam {
    epsilon: f32,
    steps: u64,
    means: Vec<f32>,
    squares: Vec<f32>,
}

impl Adam {
    /// Returns an optimizer of this many parameters. `epsilon` is added to the root of the mean squared gradient.
    pub fn new(parameters: usize, epsilon: f32) -> Self {
        Self { epsilon, steps: 0, means: vec![0.0; parameters], squares: vec![0.0; parameters] }
    }

    /// Moves parameters by one step against their gradients.
    pub fn step(&mut self, parameters: &mut [f32], gradients: &[f32], learning_rate: f64) {
        self.steps += 1;
        let correction = |decay: f32| 1.0 - f64::from(decay).powf(self.steps as f64);
        let scale = (1.0 / correction(SECOND).sqrt()) as f32;
        let rate = (learning_rate / correction(FIRST)) as f32;
        let moments = self.means.iter_mut().zip(&mut self.squares);
        for ((parameter, gradient), (mean, square)) in parameters.iter_mut().zip(gradients).zip(moments) {
            *mean += (1.0 - FIRST) * (gradient - *mean);
            *square += (1.0 - SECOND) * (gradient * gradient - *square);
            *parameter -= rate * *mean / (square.sqrt() * scale + self.epsilon);
        }
    }

    /// Adds the moments and the number of steps to a state, under names that begin with `name`.
    pub fn save(&self, name: &str, state: &mut State) {
        state.put_f32(&format!("{name}.means"), &self.means);
        state.put_f32(&format!("{name}.squares"), &self.squares);
        state.put_u64(&format!("{name}.steps"), &[self.steps]);
    }

    /// Restores the moments and the number of steps from a state.
    ///
    /// # Errors
    /// When the state does not contain them.
    pub fn restore(&mut self, name: &str, state: &State) -> Result<()> {
        state.read_f32(&format!("{name}.means"), &mut self.means)?;
        state.read_f32(&format!("{name}.squares"), &mut self.squares)?;
        [self.steps] = state.read_u64(&format!("{name}.steps"))?;
        Ok(())
    }
}

/// Number of partial sums of [`clip_norm`], so that it is vectorized.
const LANES: usize = 16;

/// Scales gradients to a norm of at most `limit` over all slices, as PyTorch's `clip_grad_norm_` does, and returns
/// their norm before. A non-finite norm leaves them unchanged.
pub fn clip_norm(gradients: &mut [&mut [f32]], limit: f32) -> f32 {
    let norm = gradients.iter().map(|slice| sum_of_squares(slice)).sum::<f64>().sqrt() as f32;
    let scale = limit / (norm + 1e-6);
    if norm.is_finite() && scale < 1.0 {
        gradients.iter_mut().for_each(|slice| slice.iter_mut().for_each(|value| *value *= scale));
    }
    norm
}

fn sum_of_squares(values: &[f32]) -> f64 {
    let mut sums = [0.0; LANES];
    let (rows, rest) = values.as_chunks::<LANES>();
    for row in rows {
        sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value * value);
    }
    let squares = rest.iter().map(|value| f64::from(value * value));
    sums.iter().map(|sum| f64::from(*sum)).chain(squares).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_is_the_learning_rate() {
        let mut parameters = [1.0, 1.0, 1.0];
        Adam::new(3, 1e-8).step(&mut parameters, &[0.5, -20.0, 0.0], 0.1);
        for (parameter, expected) in parameters.iter().zip([0.9, 1.1, 1.0]) {
            assert!((parameter - expected).abs() < 1e-6, "{parameter}");
        }
    }

    #[test]
    fn adam_finds_a_minimum() {
        let (mut parameters, mut adam) = ([3.0f32, -2.0], Adam::new(2, 1e-8));
        for _ in 0..2000 {
            let gradients = [2.0 * (parameters[0] - 1.0), 20.0 * (parameters[1] - 0.5)];
            adam.step(&mut parameters, &gradients, 0.02);
        }
        assert!((parameters[0] - 1.0).abs() < 1e-3 && (parameters[1] - 0.5).abs() < 1e-3, "{parameters:?}");
    }

    #[test]
    fn gradients_are_clipped_to_a_norm_over_all_slices() {
        let (mut a, mut b) = (vec![3.0; 16], vec![4.0; 16]);
        assert_eq!(clip_norm(&mut [&mut a, &mut b], 100.0), 20.0);
        assert_eq!((a[0], b[0]), (3.0, 4.0));
        assert_eq!(clip_norm(&mut [&mut a, &mut b], 2.0), 20.0);
        assert!((a[0] - 0.3).abs() < 1e-6 && (b[15] - 0.4).abs() < 1e-6);
        a[3] = f32::NAN;
        assert!(clip_norm(&mut [&mut a, &mut b], 2.0).is_nan());
    }
}
