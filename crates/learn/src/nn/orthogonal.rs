//! Orthogonal initialization of networks (Saxe et al. 2014).

use b2b_agent::network::{Layer, Mlp};

use crate::random::RandomStream;

/// Gains of the weights of a network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialGains {
    /// Gain of the hidden layers. Stable-Baselines3 has √2.
    pub hidden: f32,
    /// Gain of the last layer. Stable-Baselines3 has 0.01 for actors and 1 for critics.
    pub last: f32,
}

/// Returns initial parameters: weights are orthogonal matrices times a gain, and biases are 0.
pub fn orthogonal(shape: &Mlp, gains: InitialGains, random: &mut RandomStream) -> Vec<f32> {
    let mut parameters = vec![0.0; shape.parameters()];
    let last = shape.widths.len() - 2;
    for (index, layer) in shape.layers().enumerate() {
        let gain = if index == last { gains.last } else { gains.hidden };
        write_weights(&layer, gain, random, &mut parameters[layer.weights.clone()]);
    }
    parameters
}

/// Writes weights whose rows or columns, whichever are fewer, are orthogonal and of length `gain`.
pub(super) fn write_weights(layer: &Layer, gain: f32, random: &mut RandomStream, weights: &mut [f32]) {
    let (inputs, outputs) = (layer.inputs, layer.outputs);
    let vectors = orthonormal(inputs.min(outputs), inputs.max(outputs), random);
    for (index, weight) in weights.iter_mut().enumerate() {
        let (input, output) = (index / outputs, index % outputs);
        let (vector, place) = if inputs <= outputs { (input, output) } else { (output, input) };
        *weight = gain * vectors[vector][place] as f32;
    }
}

/// Returns `count` orthonormal vectors of this length, by the modified Gram-Schmidt process on vectors of normal
/// numbers.
fn orthonormal(count: usize, length: usize, random: &mut RandomStream) -> Vec<Vec<f64>> {
    let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(count);
    while vectors.len() < count {
        let mut vector: Vec<f64> = (0..length).map(|_| random.normal()).collect();
        for other in &vectors {
            let shared = dot(&vector, other);
            vector.iter_mut().zip(other).for_each(|(value, other)| *value -= shared * other);
        }
        let norm = dot(&vector, &vector).sqrt();
        // A vector that nearly depends on the others is drawn again.
        if norm > 1e-6 {
            vector.iter_mut().for_each(|value| *value /= norm);
            vectors.push(vector);
        }
    }
    vectors
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use b2b_agent::network::Activation;

    use super::*;

    #[test]
    fn weights_are_orthogonal_with_their_gain() {
        let shape = Mlp::new(6, &[40, 40], 3, Activation::Tanh);
        let gains = InitialGains { hidden: 2.0, last: 0.5 };
        let parameters = orthogonal(&shape, gains, &mut RandomStream::new(0, 0));
        for (layer, gain) in shape.layers().zip([2.0, 2.0, 0.5]) {
            let weights = &parameters[layer.weights.clone()];
            let at = |vector: usize, place: usize| match layer.inputs <= layer.outputs {
                true => weights[vector * layer.outputs + place],
                false => weights[place * layer.outputs + vector],
            };
            let (count, length) = (layer.inputs.min(layer.outputs), layer.inputs.max(layer.outputs));
            for (a, b) in (0..count).flat_map(|a| (0..count).map(move |b| (a, b))) {
                let product: f32 = (0..length).map(|place| at(a, place) * at(b, place)).sum();
                let expected = if a == b { gain * gain } else { 0.0 };
                assert!((product - expected).abs() < 1e-5, "{a} {b}: {product}");
            }
            assert!(parameters[layer.biases.clone()].iter().all(|bias| *bias == 0.0));
        }
    }
}
