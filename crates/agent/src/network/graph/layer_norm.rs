//! Layer normalization.

use super::buffer::sized;
use super::places::NormPlaces;

/// Added to the variance.
pub(crate) const EPSILON: f32 = 1e-5;
/// Number of partial sums, so that a sum is vectorized.
const LANES: usize = 8;

/// Intermediate results of a layer normalization.
#[derive(Clone, Debug, Default)]
pub struct NormTape {
    /// Values with mean 0 and variance 1: tokens × embedding.
    pub normed: Vec<f32>,
    /// One over the standard deviation of each token.
    pub inverse: Vec<f32>,
    /// Values after gain and bias: tokens × embedding.
    pub outputs: Vec<f32>,
}

/// Returns the sum of a function of values, in an order that does not depend on the machine.
pub fn lane_sum<const SLICES: usize>(slices: [&[f32]; SLICES], value: impl Fn([f32; SLICES]) -> f32) -> f32 {
    let mut sums = [0.0; LANES];
    let length = slices[0].len();
    let whole = length - length % LANES;
    for start in (0..whole).step_by(LANES) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum += value(slices.map(|slice| slice[start + lane]));
        }
    }
    let rest: f32 = (whole..length).map(|index| value(slices.map(|slice| slice[index]))).sum();
    sums.iter().sum::<f32>() + rest
}

/// Normalizes each row to mean 0 and variance 1, and applies gain and bias.
pub(super) fn normalize(
    rows: &[f32],
    width: usize,
    places: &NormPlaces,
    parameters: &[f32],
    tape: &mut NormTape,
) {
    let (gain, bias) = (&parameters[places.gain.clone()], &parameters[places.bias.clone()]);
    let normed = sized(&mut tape.normed, rows.len()).chunks_exact_mut(width);
    let outputs = sized(&mut tape.outputs, rows.len()).chunks_exact_mut(width);
    let inverse = sized(&mut tape.inverse, rows.len() / width);
    for (((row, normed), output), inverse) in rows.chunks_exact(width).zip(normed).zip(outputs).zip(inverse) {
        let mean = lane_sum([row], |[value]| value) / width as f32;
        let variance = lane_sum([row], |[value]| (value - mean) * (value - mean)) / width as f32;
        *inverse = 1.0 / (variance + EPSILON).sqrt();
        for (index, value) in row.iter().enumerate() {
            normed[index] = (value - mean) * *inverse;
            output[index] = normed[index] * gain[index] + bias[index];
        }
    }
}
