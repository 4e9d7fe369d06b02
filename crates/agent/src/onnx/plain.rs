//! A multilayer perceptron or a recurrent network as an ONNX file.

use super::file::{File, whole};
use crate::network::recurrent::{GATES, RecurrentPlaces};
use crate::network::{Activation, Actor, Distribution, Layer, Mlp, Recurrent};

/// Returns the file of a multilayer perceptron: scaling by bounds, and its layers.
pub(super) fn file(actor: &Actor, mlp: &Mlp, bounds: &[[f64; 2]], actions: usize) -> Vec<u8> {
    let mut export = FlatExport { file: File::default(), actor };
    let input = export.scaled(bounds);
    export.actions(mlp, &actor.parameters, input, actions);
    export.file.finish(&[("observation", bounds.len())], &[("action", actions)])
}

/// Returns the file of a recurrent network, whose second input is the state and whose second output the next one.
pub(super) fn recurrent(actor: &Actor, network: &Recurrent, bounds: &[[f64; 2]], actions: usize) -> Vec<u8> {
    let mut export = FlatExport { file: File::default(), actor };
    let places = network.places();
    let input = export.scaled(bounds);
    let encoder = &actor.parameters[places.encoder.clone()];
    let layers: Vec<Layer> = network.encoder.layers().collect();
    let (gates, hidden) = layers.split_last().expect("an encoder has a layer");
    let input = export.hidden(hidden, network.encoder.activation, encoder, input);
    let state = export.cell(&input, (gates, encoder), &places);
    export.actions(&network.head, &actor.parameters[places.head], state, actions);
    let width = network.state();
    let inputs = [("observation", bounds.len()), ("state", width)];
    export.file.finish(&inputs, &[("action", actions), (NEXT_STATE, width)])
}

/// Name of the output with the next state.
pub(super) const NEXT_STATE: &str = "next state";

struct FlatExport<'a> {
    file: File,
    actor: &'a Actor,
}

impl FlatExport<'_> {
    /// Adds the scaling of the observation by its bounds.
    fn scaled(&mut self, bounds: &[[f64; 2]]) -> String {
        let scale: Vec<f32> = bounds.iter().map(|[low, high]| (2.0 / (high - low)) as f32).collect();
        let offset: Vec<f32> =
            bounds.iter().map(|[low, high]| ((low + high) / (low - high)) as f32).collect();
        let width = [bounds.len()];
        let (scale, offset) = (self.file.tensor(&width, &scale), self.file.tensor(&width, &offset));
        let scaled = self.file.operator("Mul", &["observation", &scale], &[]);
        self.file.operator("Add", &[&scaled, &offset], &[])
    }

    /// Adds hidden layers.
    fn hidden(
        &mut self,
        layers: &[Layer],
        of_hidden: Activation,
        parameters: &[f32],
        input: String,
    ) -> String {
        layers.iter().fold(input, |input, layer| {
            let sums = self.linear(layer, parameters, &input, layer.outputs);
            self.file.operator(activation(of_hidden), &[&sums], &[])
        })
    }

    /// Adds the layers of a network whose first outputs are the actions. Standard deviations after the means are only
    /// for training.
    fn actions(&mut self, mlp: &Mlp, parameters: &[f32], input: String, actions: usize) {
        let layers: Vec<Layer> = mlp.layers().collect();
        let (output, hidden) = layers.split_last().expect("a network has a layer");
        let input = self.hidden(hidden, mlp.activation, parameters, input);
        let sums = self.linear(output, parameters, &input, actions);
        self.file.named(last(self.actor), &[&sums], &[], "action");
    }

    /// Adds the first outputs of a layer without its activation.
    fn linear(&mut self, layer: &Layer, parameters: &[f32], input: &str, outputs: usize) -> String {
        let weights = self.file.tensor(&[layer.inputs, outputs], &columns(parameters, layer, 0..outputs));
        let biases = self.file.tensor(&[outputs], &parameters[layer.biases.clone()][..outputs]);
        self.file.operator("Gemm", &[input, &weights, &biases], &[])
    }

    /// Adds the gated recurrent unit, and returns the next state.
    fn cell(&mut self, input: &str, gates: (&Layer, &[f32]), places: &RecurrentPlaces) -> String {
        let axis = self.file.integers(&[1], &[0]);
        let sequence = self.file.operator("Unsqueeze", &[input, &axis], &[]);
        let state = self.file.operator("Unsqueeze", &["state", &axis], &[]);
        let cell = (&places.cell, &self.actor.parameters[..]);
        let states = gated_unit(&mut self.file, [&sequence, &state], gates, cell);
        let axes = self.file.integers(&[2], &[0, 1]);
        self.file.named("Squeeze", &[&states, &axes], &[], NEXT_STATE);
        NEXT_STATE.to_owned()
    }
}

/// Adds a gated recurrent unit of a layer from the input and a layer from the state, each with its parameters. Sequence
/// and state have the shape [1, batch, width]. Returns the next states, of shape [1, 1, batch, width].
pub(super) fn gated_unit(
    file: &mut File,
    [sequence, state]: [&str; 2],
    (gates, of_gates): (&Layer, &[f32]),
    (cell, parameters): (&Layer, &[f32]),
) -> String {
    let shape = |layer: &Layer| [1, layer.outputs, layer.inputs];
    let of_input = file.tensor(&shape(gates), &transposed(of_gates, gates));
    let of_state = file.tensor(&shape(cell), &transposed(parameters, cell));
    let biases = [&of_gates[gates.biases.clone()], &parameters[cell.biases.clone()]].concat();
    let biases = file.tensor(&[1, 2 * GATES * cell.inputs], &biases);
    let attributes = [whole("hidden_size", cell.inputs), whole("linear_before_reset", 1)];
    // The fifth input, the length of each sequence, is left out: all are complete.
    file.operator("GRU", &[sequence, &of_input, &of_state, &biases, "", state], &attributes)
}

/// Returns the weights of a layer, with a row for each output.
fn transposed(parameters: &[f32], layer: &Layer) -> Vec<f32> {
    (0..layer.outputs).flat_map(|output| columns(parameters, layer, output..output + 1)).collect()
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
