//! Multilayer perceptrons.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{Activation, Tensor};

/// The shape of a multilayer perceptron: the activation follows every layer but the last.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mlp {
    /// Widths of input, hidden layers and output.
    pub widths: Vec<usize>,
    /// Activation of the hidden layers.
    pub activation: Activation,
}

/// A layer: its widths and the ranges of its weights and biases in the parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Range of the weights, `inputs` rows of `outputs`.
    pub weights: Range<usize>,
    /// Range of the biases.
    pub biases: Range<usize>,
}

impl Mlp {
    /// Creates a shape with these widths.
    pub fn new(inputs: usize, hidden: &[usize], outputs: usize, activation: Activation) -> Self {
        let widths = std::iter::once(inputs).chain(hidden.iter().copied()).chain([outputs]).collect();
        Self { widths, activation }
    }

    /// Returns the number of inputs.
    pub fn inputs(&self) -> usize {
        self.widths[0]
    }

    /// Returns the number of outputs.
    pub fn outputs(&self) -> usize {
        self.widths[self.widths.len() - 1]
    }

    /// Returns the layers in order.
    pub fn layers(&self) -> impl Iterator<Item = Layer> {
        let mut at = 0;
        self.widths.windows(2).map(move |pair| {
            let (inputs, outputs) = (pair[0], pair[1]);
            let weights = at..at + inputs * outputs;
            let biases = weights.end..weights.end + outputs;
            at = biases.end;
            Layer { inputs, outputs, weights, biases }
        })
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.layers().last().map_or(0, |layer| layer.biases.end)
    }

    /// Returns the tensors of all layers, whose names begin with a prefix and the number of the layer.
    pub(super) fn tensors(&self, prefix: &str) -> Vec<Tensor> {
        self.layers()
            .enumerate()
            .flat_map(|(index, layer)| layer.tensors(&format!("{prefix}{index}")))
            .collect()
    }

    /// Returns a buffer for [`Mlp::forward`].
    pub fn scratch(&self) -> Vec<f32> {
        vec![0.0; 2 * self.widths.iter().max().copied().unwrap_or(0)]
    }

    /// Writes the outputs for one input. Allocates nothing, and gives the same bits on every machine.
    ///
    /// # Panics
    /// If the length of `input` or `output` does not match the shape, or `parameters` or `scratch` is too short.
    pub fn forward(&self, parameters: &[f32], input: &[f32], scratch: &mut [f32], output: &mut [f32]) {
        assert_eq!(
            (input.len(), output.len()),
            (self.inputs(), self.outputs()),
            "widths of input and output"
        );
        let (mut from, mut to) = scratch.split_at_mut(scratch.len() / 2);
        from[..input.len()].copy_from_slice(input);
        let last = self.widths.len() - 2;
        for (index, layer) in self.layers().enumerate() {
            let values = &mut to[..layer.outputs];
            layer.forward(parameters, &from[..layer.inputs], values);
            if index < last {
                self.activation.apply(values);
            }
            std::mem::swap(&mut from, &mut to);
        }
        output.copy_from_slice(&from[..output.len()]);
    }
}

/// Rows and outputs that [`Layer::forward_rows`] computes together, in registers.
const TILE: (usize, usize) = (4, 8);

impl Layer {
    /// Writes the outputs for one input.
    pub(super) fn forward(&self, parameters: &[f32], input: &[f32], output: &mut [f32]) {
        output.copy_from_slice(&parameters[self.biases.clone()]);
        let rows = parameters[self.weights.clone()].chunks_exact(self.outputs);
        for (value, row) in input.iter().zip(rows) {
            output.iter_mut().zip(row).for_each(|(sum, weight)| *sum += value * weight);
        }
    }

    /// Writes the outputs for rows of inputs, bit-identical to the outputs for each row on its own.
    ///
    /// # Panics
    /// If `inputs` and `outputs` differ in their number of rows, or `parameters` is too short.
    pub fn forward_rows(&self, parameters: &[f32], inputs: &[f32], outputs: &mut [f32]) {
        let rows = outputs.len() / self.outputs;
        assert_eq!(inputs.len(), rows * self.inputs, "inputs of a layer");
        let tiled = (rows - rows % TILE.0, self.outputs - self.outputs % TILE.1);
        for row in (0..tiled.0).step_by(TILE.0) {
            for first in (0..tiled.1).step_by(TILE.1) {
                self.forward_tile(parameters, inputs, row, first, outputs);
            }
        }
        self.forward_rest(parameters, inputs, 0..tiled.0, tiled.1..self.outputs, outputs);
        self.forward_rest(parameters, inputs, tiled.0..rows, 0..self.outputs, outputs);
    }

    fn forward_tile(
        &self,
        parameters: &[f32],
        inputs: &[f32],
        row: usize,
        first: usize,
        outputs: &mut [f32],
    ) {
        let biases = &parameters[self.biases.clone()][first..];
        let mut sums = [[0.0; TILE.1]; TILE.0];
        sums.iter_mut().for_each(|sums| sums.copy_from_slice(&biases[..TILE.1]));
        let inputs: [&[f32]; TILE.0] =
            std::array::from_fn(|each| &inputs[(row + each) * self.inputs..][..self.inputs]);
        let weights = parameters[self.weights.clone()].chunks_exact(self.outputs);
        for (input, weights) in weights.enumerate() {
            let weights: [f32; TILE.1] = std::array::from_fn(|output| weights[first..][output]);
            for (sums, inputs) in sums.iter_mut().zip(inputs) {
                let value = inputs[input];
                sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += value * weight);
            }
        }
        for (each, sums) in sums.iter().enumerate() {
            outputs[(row + each) * self.outputs + first..][..TILE.1].copy_from_slice(sums);
        }
    }

    fn forward_rest(
        &self,
        parameters: &[f32],
        inputs: &[f32],
        rows: Range<usize>,
        columns: Range<usize>,
        outputs: &mut [f32],
    ) {
        for row in rows {
            let output = &mut outputs[row * self.outputs..][columns.clone()];
            output.copy_from_slice(&parameters[self.biases.clone()][columns.clone()]);
            let weights = parameters[self.weights.clone()].chunks_exact(self.outputs);
            for (value, weights) in inputs[row * self.inputs..][..self.inputs].iter().zip(weights) {
                let weights = &weights[columns.clone()];
                output.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += value * weight);
            }
        }
    }

    /// Returns the tensors of the layer, whose names begin with `name`.
    pub fn tensors(&self, name: &str) -> [Tensor; 2] {
        let tensor = |part: &str, sizes, place: &Range<usize>| Tensor {
            name: format!("{name}.{part}"),
            sizes,
            place: place.clone(),
        };
        [
            tensor("weight", vec![self.inputs, self.outputs], &self.weights),
            tensor("bias", vec![self.outputs], &self.biases),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_computes_its_layers_in_turn() {
        let shape = Mlp::new(2, &[2], 1, Activation::Relu);
        // Hidden: x + 1 and y - x; output: 2 h₁ + 3 h₂ - 1.
        let parameters = [1.0, -1.0, 0.0, 1.0, 1.0, 0.0, 2.0, 3.0, -1.0];
        assert_eq!(shape.parameters(), parameters.len());
        let mut output = [0.0];
        let mut scratch = shape.scratch();
        shape.forward(&parameters, &[1.0, 3.0], &mut scratch, &mut output);
        assert_eq!(output, [2.0 * 2.0 + 3.0 * 2.0 - 1.0]);
        shape.forward(&parameters, &[-3.0, -4.0], &mut scratch, &mut output);
        assert_eq!(output, [-1.0]);
    }

    #[test]
    fn rows_are_bit_identical_to_single_inputs() {
        let shape = Mlp::new(5, &[], 19, Activation::Tanh);
        let number = |index: usize| ((index * 7919) % 101) as f32 / 50.0 - 1.0;
        let parameters: Vec<f32> = (0..shape.parameters()).map(number).collect();
        let layer = shape.layers().next().unwrap();
        for rows in [1, 4, 11] {
            let inputs: Vec<f32> = (0..rows * 5).map(|index| number(index + 3)).collect();
            let mut outputs = vec![f32::NAN; rows * 19];
            layer.forward_rows(&parameters, &inputs, &mut outputs);
            for (input, output) in inputs.chunks(5).zip(outputs.chunks(19)) {
                let mut single = [0.0; 19];
                layer.forward(&parameters, input, &mut single);
                assert_eq!(output, single);
            }
        }
    }

    #[test]
    fn layers_fill_the_parameters_without_gaps() {
        let shape = Mlp::new(3, &[5, 4], 2, Activation::Tanh);
        let mut at = 0;
        for layer in shape.layers() {
            assert_eq!((layer.weights.start, layer.biases.start), (at, layer.weights.end));
            at = layer.biases.end;
        }
        assert_eq!(at, shape.parameters());
        assert_eq!(at, 3 * 5 + 5 + 5 * 4 + 4 + 4 * 2 + 2);
    }
}
