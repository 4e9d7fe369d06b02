//! Gradients of graph networks.

use b2b_agent::network::Layer;
use b2b_agent::network::graph::{
    Batch, BlockPlaces, BlockTape, GraphNetwork, MemoryPlaces, NormPlaces, NormTape, Places, Tape, lane_sum,
    sized,
};

use super::attention::{self, Attended};
use crate::nn::cell::CellPass;
use crate::nn::pass::add_parameter_gradients;
use crate::nn::{Matrix, multiply};

/// Buffers of backward passes, which grow to the largest batch and are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Gradients {
    /// Gradients of the outputs of the tokens of each type.
    pub outputs: Vec<Vec<f32>>,
    /// Gradients of the embeddings: tokens × embedding.
    stream: Vec<f32>,
    /// Gradients of a sublayer's output, which is added to the embeddings, and of its inputs.
    change: Vec<f32>,
    /// Gradients of the outputs of hidden layers.
    hidden: Vec<f32>,
    /// Gradients of queries, keys and values.
    projections: Vec<f32>,
    /// Values of a head of one building, and gradients of the weights of a node.
    columns: Vec<f32>,
}

/// A network with its parameters and the sums of their gradients.
pub(super) struct Target<'a> {
    pub network: &'a GraphNetwork,
    pub places: &'a Places,
    pub parameters: &'a [f32],
    pub sums: &'a mut [f32],
}

impl Gradients {
    /// Makes room for the gradients of the outputs of a forward pass, and sets them to 0.
    pub fn begin(&mut self, network: &GraphNetwork, tape: &Tape) {
        self.outputs.resize(network.types.len(), Vec::new());
        for ((buffer, node), count) in self.outputs.iter_mut().zip(&network.types).zip(&tape.counts) {
            sized(buffer, count * node.outputs).fill(0.0);
        }
    }

    /// Propagates the gradients of the outputs of a forward pass to the parameters. `cell` made the pass through the
    /// memory.
    pub fn propagate(&mut self, target: &mut Target<'_>, tape: &Tape, cell: &mut CellPass, batch: Batch<'_>) {
        let (network, places) = (target.network, target.places);
        let length = tape.tokens() * network.embedding;
        self.decoders(target, tape);
        if let Some(memory) = &places.memory {
            self.memory(memory, target, tape, cell);
        }
        sized(&mut self.stream, length).fill(0.0);
        add_norm(&places.norm, &tape.norm, &self.change[..length], target, &mut self.stream[..length]);
        for (layer, block) in places.blocks.iter().enumerate().rev() {
            self.feed_forward(target, block, &tape.blocks[layer], tape);
            self.attend(target, block, &tape.blocks[layer], tape, batch);
        }
        self.encoders(target, tape);
    }

    /// Replaces the gradients of the states in `change` by the gradients of the embeddings.
    fn memory(&mut self, places: &MemoryPlaces, target: &mut Target<'_>, tape: &Tape, pass: &mut CellPass) {
        let MemoryPlaces { input, cell } = places;
        let (_, of_states) = pass.gradients(cell);
        of_states.copy_from_slice(&self.change[..of_states.len()]);
        let of_input = pass.backward(cell, target.parameters, target.sums);
        let embeddings = tape.embeddings(target.network);
        backward(input, target, embeddings, of_input, sized(&mut self.change, embeddings.len()));
    }

    /// Writes the gradients of the inputs of the decoders to `change`.
    fn decoders(&mut self, target: &mut Target<'_>, tape: &Tape) {
        let width = target.network.decoded();
        let change = sized(&mut self.change, tape.tokens() * width);
        change.fill(0.0);
        for (index, layer) in target.places.decoders.iter().enumerate() {
            let count = tape.counts[index];
            if count == 0 || layer.outputs == 0 {
                continue;
            }
            let of_decoded = sized(&mut self.hidden, count * width);
            let gradients = &self.outputs[index][..count * layer.outputs];
            backward(layer, target, &tape.decoded[index][..count * width], gradients, of_decoded);
            for token in (0..tape.tokens()).filter(|token| tape.types[*token] == index) {
                let place = tape.places[token] * width;
                change[token * width..][..width].copy_from_slice(&of_decoded[place..place + width]);
            }
        }
    }

    fn feed_forward(
        &mut self,
        target: &mut Target<'_>,
        places: &BlockPlaces,
        block: &BlockTape,
        tape: &Tape,
    ) {
        let (tokens, network) = (tape.tokens(), target.network);
        let stream = &mut self.stream[..tokens * network.embedding];
        let hidden = &block.hidden[..tokens * network.feed_forward];
        let of_hidden = sized(&mut self.hidden, hidden.len());
        backward(&places.narrowing, target, hidden, stream, of_hidden);
        network.activation.backward(hidden, of_hidden);
        let change = &mut self.change[..stream.len()];
        backward(&places.hidden, target, &block.before_hidden.outputs[..stream.len()], of_hidden, change);
        add_norm(&places.before_hidden, &block.before_hidden, change, target, stream);
    }

    fn attend(
        &mut self,
        target: &mut Target<'_>,
        places: &BlockPlaces,
        block: &BlockTape,
        tape: &Tape,
        batch: Batch<'_>,
    ) {
        let (width, heads) = (target.network.embedding, target.network.heads);
        let stream = &mut self.stream[..tape.tokens() * width];
        let change = &mut self.change[..stream.len()];
        backward(&places.mixing, target, &block.mixed[..stream.len()], stream, change);
        let projections = sized(&mut self.projections, 3 * stream.len());
        for (span, graph) in tape.rows.iter().zip(batch.graphs()) {
            let (nodes, end) = (span.nodes, span.first + span.nodes);
            let attended = Attended {
                projections: &block.projections[3 * width * span.first..3 * width * end],
                weights: &block.weights[span.weights..][..heads * nodes * nodes],
                relations: &graph.relations,
                heads,
                nodes,
            };
            attention::backward(
                attended,
                &change[span.first * width..end * width],
                &mut projections[3 * width * span.first..3 * width * end],
                &mut target.sums[places.edges.clone()],
                sized(&mut self.columns, nodes * (width / heads + 1)),
            );
        }
        let inputs = &block.before_attention.outputs[..stream.len()];
        backward(&places.projections, target, inputs, projections, change);
        add_norm(&places.before_attention, &block.before_attention, change, target, stream);
    }

    fn encoders(&mut self, target: &mut Target<'_>, tape: &Tape) {
        let width = target.network.embedding;
        for (index, encoder) in target.places.encoders.iter().enumerate() {
            let (count, features) = (tape.counts[index], encoder.layer.inputs);
            let gathered = sized(&mut self.change, count * width);
            for token in (0..tape.tokens()).filter(|token| tape.types[*token] == index) {
                let gradients = &self.stream[token * width..][..width];
                gathered[tape.places[token] * width..][..width].copy_from_slice(gradients);
            }
            let inputs = &tape.inputs[index][..count * features];
            add_parameter_gradients(&encoder.layer, inputs, gathered, count, target.sums);
        }
    }
}

/// Adds the gradients of a layer's parameters, and writes the gradients of its inputs.
fn backward(
    layer: &Layer,
    target: &mut Target<'_>,
    inputs: &[f32],
    gradients: &[f32],
    of_inputs: &mut [f32],
) {
    let rows = gradients.len() / layer.outputs;
    add_parameter_gradients(layer, inputs, gradients, rows, target.sums);
    let weights = Matrix::new(&target.parameters[layer.weights.clone()], layer.inputs, layer.outputs);
    multiply(Matrix::new(gradients, rows, layer.outputs), weights.transposed(), 0.0, of_inputs);
}

/// Adds the gradients of gain and bias of a layer normalization, and adds the gradients of its inputs to `stream`.
fn add_norm(
    places: &NormPlaces,
    tape: &NormTape,
    gradients: &[f32],
    target: &mut Target<'_>,
    stream: &mut [f32],
) {
    let gain = &target.parameters[places.gain.clone()];
    let width = gain.len();
    let rows = gradients.chunks_exact(width).zip(tape.normed.chunks_exact(width)).zip(&tape.inverse);
    for (((gradients, normed), inverse), stream) in rows.zip(stream.chunks_exact_mut(width)) {
        let mean = lane_sum([gradients, gain], |[gradient, gain]| gradient * gain) / width as f32;
        let along = lane_sum([gradients, gain, normed], |[gradient, gain, value]| gradient * gain * value)
            / width as f32;
        for index in 0..width {
            let value = gradients[index] * gain[index] - mean - normed[index] * along;
            stream[index] += inverse * value;
        }
        let of_gain = target.sums[places.gain.clone()].iter_mut().zip(gradients.iter().zip(normed));
        of_gain.for_each(|(sum, (gradient, value))| *sum += gradient * value);
        let of_bias = target.sums[places.bias.clone()].iter_mut().zip(gradients);
        of_bias.for_each(|(sum, gradient)| *sum += gradient);
    }
}
