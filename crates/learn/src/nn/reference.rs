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

/// Replaces the state of a gated recurrent unit by the next one, given the inputs of its gates from the input and from
/// the state.
pub(crate) fn next_state(of_input: &[f64], of_state: &[f64], state: &mut [f64]) {
    let (logistic, width) = (|x: f64| 1.0 / (1.0 + (-x).exp()), state.len());
    for (unit, state) in state.iter_mut().enumerate() {
        let [update, reset, candidate] = [0, 1, 2].map(|gate| gate * width + unit);
        let z = logistic(of_input[update] + of_state[update]);
        let r = logistic(of_input[reset] + of_state[reset]);
        let n = (of_input[candidate] + r * of_state[candidate]).tanh();
        *state = (1.0 - z) * n + z * *state;
    }
}

/// Asserts that gradients equal the central finite differences of a loss.
pub(crate) fn assert_gradients(at: &[f64], gradients: &[f32], mut loss: impl FnMut(&[f64]) -> f64) {
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
