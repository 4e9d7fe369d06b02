//! A multilayer perceptron as an ONNX file.

use super::file::File;
use crate::network::{Activation, Actor, Distribution, Layer, Mlp};

/// Returns the file: scaling by bounds, and the layers of the network.
pub(super) fn file(actor: &Actor, mlp: &Mlp, bounds: &[[f64; 2]], actions: usize) -> Vec<u8> {
    let scale: Vec<f32> = bounds.iter().map(|[low, high]| (2.0 / (high - low)) as f32).collect();
    let offset: Vec<f32> = bounds.iter().map(|[low, high]| ((low + high) / (low - high)) as f32).collect();
    let (width, mut file) = (bounds.len(), File::default());
    let (scale, offset) = (file.tensor(&[width], &scale), file.tensor(&[width], &offset));
    let scaled = file.operator("Mul", &["observation", &scale], &[]);
    let mut input = file.operator("Add", &[&scaled, &offset], &[]);
    let layers: Vec<Layer> = mlp.layers().collect();
    for (index, layer) in layers.iter().enumerate() {
        let is_last = index + 1 == layers.len();
        // Standard deviations after the means of the last layer are only for training.
        let outputs = if is_last { actions } else { layer.outputs };
        let weights = file.tensor(&[layer.inputs, outputs], &columns(&actor.parameters, layer, 0..outputs));
        let biases = file.tensor(&[outputs], &actor.parameters[layer.biases.clone()][..outputs]);
        let sums = file.operator("Gemm", &[&input, &weights, &biases], &[]);
        if is_last {
            file.named(last(actor), &[&sums], &[], "action");
        } else {
            input = file.operator(activation(mlp.activation), &[&sums], &[]);
        }
    }
    file.finish(("observation", width), ("action", actions))
}

/// Returns the weights of some columns of a layer.
pub(super) fn columns(parameters: &[f32], layer: &Layer, columns: std::ops::Range<usize>) -> Vec<f32> {
    let rows = parameters[layer.weights.clone()].chunks_exact(layer.outputs);
    rows.flat_map(|row| &row[columns.clone()]).copied().collect()
}

/// Returns the operator of an activation.
pub(super) fn activation(activation: Activation) -> &'static str {
    match activation {
        Activation::Tanh => "Tanh",
        Activation::Relu => "Relu",
    }
}

/// Returns the operator after the outputs of an actor.
pub(super) fn last(actor: &Actor) -> &'static str {
    match actor.distribution {
        Distribution::SquashedGaussian => "Tanh",
        _ => "Identity",
    }
}
