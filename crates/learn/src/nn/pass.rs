//! Forward and backward passes over batches.

use b2b_agent::network::graph::sized;
use b2b_agent::network::{Layer, Mlp};

use super::product::{Matrix, multiply};

/// Buffers for passing batches through a network. They grow to the largest batch and are reused.
///
/// 1. [`Pass::forward`] keeps the outputs of every layer.
/// 2. [`Pass::backward`] reads them, from the last layer to the first.
#[derive(Clone, Debug)]
pub struct Pass {
    shape: Mlp,
    layers: Vec<Layer>,
    rows: usize,
    /// Outputs of each layer, after its activation: rows × outputs.
    outputs: Vec<Vec<f32>>,
    /// Gradients of the outputs of a layer, and of its inputs.
    gradients: [Vec<f32>; 2],
}

impl Pass {
    /// Returns the buffers of a shape.
    pub fn new(shape: &Mlp) -> Self {
        let layers: Vec<Layer> = shape.layers().collect();
        let outputs = vec![Vec::new(); layers.len()];
        Self { shape: shape.clone(), layers, rows: 0, outputs, gradients: Default::default() }
    }

    /// Returns the outputs of the last forward pass: rows × outputs.
    pub fn outputs(&self) -> &[f32] {
        let last = self.layers.len() - 1;
        &self.outputs[last][..self.rows * self.shape.outputs()]
    }

    /// Computes and returns the outputs for `rows` inputs, rows × inputs: rows × outputs.
    ///
    /// # Panics
    /// When `parameters` is too short for the shape, or `inputs` is not rows × inputs values.
    pub fn forward(&mut self, parameters: &[f32], inputs: &[f32], rows: usize) -> &[f32] {
        self.rows = rows;
        for index in 0..self.layers.len() {
            let layer = &self.layers[index];
            let (before, after) = self.outputs.split_at_mut(index);
            let inputs = before.last().map_or(inputs, |outputs| &outputs[..rows * layer.inputs]);
            let outputs = sized(&mut after[0], rows * layer.outputs);
            forward(layer, parameters, inputs, outputs);
            if index + 1 < self.layers.len() {
                self.shape.activation.apply(outputs);
            }
        }
        self.outputs()
    }

    /// Propagates the gradients of the outputs of the last forward pass, rows × outputs. Adds the gradients of the
    /// parameters to `parameter_gradients`, and writes the gradients of the inputs, rows × inputs, to
    /// `input_gradients`.
    ///
    /// # Panics
    /// When a slice is too short, or `inputs` or `input_gradients` does not have as many values as the inputs of the
    /// last forward pass.
    pub fn backward(
        &mut self,
        parameters: &[f32],
        inputs: &[f32],
        output_gradients: &[f32],
        mut parameter_gradients: Option<&mut [f32]>,
        mut input_gradients: Option<&mut [f32]>,
    ) {
        let rows = self.rows;
        let [current, next] = &mut self.gradients;
        sized(current, output_gradients.len()).copy_from_slice(output_gradients);
        for (index, layer) in self.layers.iter().enumerate().rev() {
            let inputs = match index {
                0 => inputs,
                _ => &self.outputs[index - 1][..rows * layer.inputs],
            };
            let gradients = &current[..rows * layer.outputs];
            if let Some(sums) = parameter_gradients.as_deref_mut() {
                add_parameter_gradients(layer, inputs, gradients, rows, sums);
            }
            let weights = Matrix::new(&parameters[layer.weights.clone()], layer.inputs, layer.outputs);
            let gradients = Matrix::new(gradients, rows, layer.outputs);
            if index > 0 {
                let of_inputs = sized(next, rows * layer.inputs);
                multiply(gradients, weights.transposed(), 0.0, of_inputs);
                self.shape.activation.backward(inputs, of_inputs);
                std::mem::swap(current, next);
            } else if let Some(of_inputs) = input_gradients.as_deref_mut() {
                multiply(gradients, weights.transposed(), 0.0, of_inputs);
            }
        }
    }
}

/// Computes the outputs of a layer for rows of inputs.
pub(super) fn forward(layer: &Layer, parameters: &[f32], inputs: &[f32], outputs: &mut [f32]) {
    let rows = outputs.len() / layer.outputs;
    let biases = &parameters[layer.biases.clone()];
    outputs.chunks_exact_mut(layer.outputs).for_each(|row| row.copy_from_slice(biases));
    let weights = Matrix::new(&parameters[layer.weights.clone()], layer.inputs, layer.outputs);
    multiply(Matrix::new(inputs, rows, layer.inputs), weights, 1.0, outputs);
}

/// Adds the gradients of the weights and the biases of a layer to `sums`.
pub(super) fn add_parameter_gradients(
    layer: &Layer,
    inputs: &[f32],
    gradients: &[f32],
    rows: usize,
    sums: &mut [f32],
) {
    let inputs = Matrix::new(inputs, rows, layer.inputs).transposed();
    multiply(inputs, Matrix::new(gradients, rows, layer.outputs), 1.0, &mut sums[layer.weights.clone()]);
    let biases = &mut sums[layer.biases.clone()];
    for row in gradients.chunks_exact(layer.outputs) {
        biases.iter_mut().zip(row).for_each(|(sum, gradient)| *sum += gradient);
    }
}

#[cfg(test)]
mod tests {
    use b2b_agent::network::Activation;

    use super::*;
    use crate::nn::reference::{self, assert_gradients};
    use crate::nn::{InitialGains, orthogonal};
    use crate::random::RandomStream;

    fn network(activation: Activation) -> (Mlp, Vec<f32>, Vec<f32>, RandomStream) {
        let shape = Mlp::new(5, &[16, 12], 3, activation);
        let mut random = RandomStream::new(4, 0);
        let gains = InitialGains { hidden: 1.4, last: 1.0 };
        let mut parameters = orthogonal(&shape, gains, &mut random);
        parameters.iter_mut().for_each(|value| *value += 0.1 * random.normal() as f32);
        let mut inputs = vec![0.0; 7 * 5];
        random.normals(&mut inputs);
        (shape, parameters, inputs, random)
    }

    #[test]
    fn a_batch_has_the_outputs_of_single_inputs() {
        for activation in [Activation::Tanh, Activation::Relu] {
            let (shape, parameters, inputs, _) = network(activation);
            let mut pass = Pass::new(&shape);
            let outputs = pass.forward(&parameters, &inputs, 7).to_vec();
            let (mut scratch, mut single) = (shape.scratch(), [0.0; 3]);
            for (input, output) in inputs.chunks(5).zip(outputs.chunks(3)) {
                shape.forward(&parameters, input, &mut scratch, &mut single);
                assert!(
                    output.iter().zip(&single).all(|(a, b)| (a - b).abs() < 1e-5),
                    "{output:?} {single:?}"
                );
            }
        }
    }

    #[test]
    fn gradients_match_finite_differences() {
        for activation in [Activation::Tanh, Activation::Relu] {
            let (shape, parameters, inputs, mut random) = network(activation);
            let mut weights = vec![0.0; 7 * 3];
            random.normals(&mut weights);
            let loss = |parameters: &[f64], inputs: &[f64]| -> f64 {
                let outputs =
                    inputs.chunks(5).flat_map(|input| reference::forward(&shape, parameters, input));
                outputs.zip(&weights).map(|(output, weight)| output * f64::from(*weight)).sum()
            };
            let mut pass = Pass::new(&shape);
            pass.forward(&parameters, &inputs, 7);
            let (mut of_parameters, mut of_inputs) = (vec![0.0; parameters.len()], vec![0.0; inputs.len()]);
            pass.backward(&parameters, &inputs, &weights, Some(&mut of_parameters), Some(&mut of_inputs));
            let (parameters, inputs) = (reference::wide(&parameters), reference::wide(&inputs));
            assert_gradients(&parameters, &of_parameters, |parameters| loss(parameters, &inputs));
            assert_gradients(&inputs, &of_inputs, |inputs| loss(&parameters, inputs));
        }
    }

    #[test]
    fn gradients_accumulate_and_buffers_serve_smaller_batches() {
        let (shape, parameters, inputs, _) = network(Activation::Tanh);
        let gradients = [1.0; 7 * 3];
        let mut pass = Pass::new(&shape);
        let mut sums = vec![0.0; parameters.len()];
        for rows in [0..7, 0..3, 3..7] {
            let inputs = &inputs[5 * rows.start..5 * rows.end];
            pass.forward(&parameters, inputs, rows.len());
            let sign = if rows.len() == 7 { 1.0 } else { -1.0 };
            let signed: Vec<f32> = gradients[..3 * rows.len()].iter().map(|value| sign * value).collect();
            pass.backward(&parameters, inputs, &signed, Some(&mut sums), None);
        }
        assert!(sums.iter().all(|sum| sum.abs() < 1e-5), "{sums:?}");
    }
}
