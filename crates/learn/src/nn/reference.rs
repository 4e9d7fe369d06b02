//! Double-precision networks and finite differences, against which tests compare gradients.

use b2b_agent::network::{Activation, Mlp};

/// Returns the values in double precision.
pub(crate) fn wide(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| f64::from(*value)).collect()
}

/// Returns the outputs for one input.
pub(crate) fn forward(shape: &Mlp, parameters: &[f64], input: &[f64]) -> Vec<f64> {
    let mut values = input.to_vec();
    let last = shape.widths.len() - 2;
    for (index, layer) in shape.layers().enumerate() {
        let mut outputs = parameters[layer.biases.clone()].to_vec();
        for (value, row) in values.iter().zip(parameters[layer.weights.clone()].chunks(layer.outputs)) {
            outputs.iter_mut().zip(row).for_each(|(sum, weight)| *sum += value * weight);
        }
        if index < last {
            outputs.iter_mut().for_each(|value| match shape.activation {
                Activation::Tanh => *value = value.tanh(),
                Activation::Relu => *value = value.max(0.0),
            });
        }
        values = outputs;
    }
    values
}

/// Asserts that gradients equal the central finite differences of a loss.
pub(crate) fn assert_gradients(at: &[f64], gradients: &[f32], loss: impl Fn(&[f64]) -> f64) {
    const STEP: f64 = 1e-6;
    assert_eq!(at.len(), gradients.len());
    let mut moved = at.to_vec();
    for (index, gradient) in gradients.iter().enumerate() {
        moved[index] = at[index] + STEP;
        let above = loss(&moved);
        moved[index] = at[index] - STEP;
        let difference = (above - loss(&moved)) / (2.0 * STEP);
        moved[index] = at[index];
        let error = (difference - f64::from(*gradient)).abs();
        assert!(
            error < 2e-5 + 1e-3 * difference.abs(),
            "value {index}: {gradient}, differences {difference}"
        );
    }
    let largest = gradients.iter().fold(0.0f32, |largest, gradient| largest.max(gradient.abs()));
    assert!(largest > 1e-3, "gradients are all small: {largest}");
}
