//! Multilayer perceptrons.

use serde::{Deserialize, Serialize};

use super::Activation;

/// The shape of a multilayer perceptron: the activation follows every layer but the last.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mlp {
    /// Widths of input, hidden layers and output.
    pub widths: Vec<usize>,
    /// Activation of the hidden layers.
    pub activation: Activation,
}

/// A layer: its widths, and where its weights and biases are among the parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Place of the weights, `inputs` rows of `outputs`.
    pub weights: std::ops::Range<usize>,
    /// Place of the biases.
    pub biases: std::ops::Range<usize>,
}

impl Mlp {
    /// Returns the shape with these widths.
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

    /// Returns room for [`Mlp::forward`].
    pub fn scratch(&self) -> Vec<f32> {
        vec![0.0; 2 * self.widths.iter().max().copied().unwrap_or(0)]
    }

    /// Writes the outputs for one input. Allocates nothing, and gives the same bits on every machine.
    ///
    /// # Panics
    /// When a slice has another length than the shape.
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

impl Layer {
    fn forward(&self, parameters: &[f32], input: &[f32], output: &mut [f32]) {
        output.copy_from_slice(&parameters[self.biases.clone()]);
        let rows = parameters[self.weights.clone()].chunks_exact(self.outputs);
        for (value, row) in input.iter().zip(rows) {
            output.iter_mut().zip(row).for_each(|(sum, weight)| *sum += value * weight);
        }
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
