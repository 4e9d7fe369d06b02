//! The forward pass.

use std::sync::Arc;

use super::attention::{EdgeScores, attend};
use super::buffer::sized;
use super::layer_norm::{NormTape, normalize};
use super::network::GraphNetwork;
use super::places::{BlockPlaces, MemoryPlaces, Places};
use super::topology::Graph;
use crate::network::Layer;
use crate::network::recurrent::step;

/// Limit of a normalized feature, in standard deviations.
pub(crate) const LARGEST: f32 = 10.0;

/// Computes the outputs of a layer for any number of rows of inputs: layer, parameters, inputs, outputs.
pub type Linear = fn(&Layer, &[f32], &[f32], &mut [f32]);

/// Observations of several buildings.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// Buildings.
    pub graphs: &'a [Arc<Graph>],
    /// Building of each row.
    pub of_rows: &'a [usize],
    /// Rows of observations, each padded to `width`.
    pub observations: &'a [f32],
    /// Numbers in a row.
    pub width: usize,
}

impl<'a> Batch<'a> {
    /// Returns the batch of one observation of a building.
    pub fn of_one(graph: &'a Arc<Graph>, observation: &'a [f32]) -> Self {
        Self {
            graphs: std::slice::from_ref(graph),
            of_rows: &[0],
            observations: observation,
            width: graph.width(),
        }
    }

    /// Returns the building of each row.
    pub fn graphs(self) -> impl Iterator<Item = &'a Graph> {
        self.of_rows.iter().map(move |graph| &*self.graphs[*graph])
    }
}

/// Intermediate results of a forward pass, for the backward pass. Buffers grow to the largest batch and are reused.
///
/// The nodes of all rows of a batch are one list of tokens, row after row.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    /// Tokens of each row.
    pub rows: Vec<Span>,
    /// Type of each token.
    pub types: Vec<usize>,
    /// Index of each token among the tokens of its type.
    pub places: Vec<usize>,
    /// Number of tokens of each type.
    pub counts: Vec<usize>,
    /// Normalized features of the tokens of each type.
    pub inputs: Vec<Vec<f32>>,
    /// Layers of the transformer.
    pub blocks: Vec<BlockTape>,
    /// Normalization after the transformer.
    pub norm: NormTape,
    /// Inputs of the decoder of each type.
    pub decoded: Vec<Vec<f32>>,
    /// Outputs of the tokens of each type.
    pub outputs: Vec<Vec<f32>>,
    /// Embeddings of the tokens between the layers.
    stream: Vec<f32>,
    /// Residual that a part of a layer adds to the embeddings.
    change: Vec<f32>,
    /// Keys of a head of one building.
    keys: Vec<f32>,
    /// Inputs of the gates from the embeddings, and from the states.
    gates: [Vec<f32>; 2],
}

/// The tokens of a row, and its attention.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// First token.
    pub first: usize,
    /// Number of tokens: nodes of the building.
    pub nodes: usize,
    /// Start of its attention weights.
    pub weights: usize,
}

/// Intermediate results of a transformer layer.
#[derive(Clone, Debug, Default)]
pub struct BlockTape {
    /// Normalization before the attention.
    pub before_attention: NormTape,
    /// Queries, keys and values: tokens × three times the embedding.
    pub projections: Vec<f32>,
    /// Attention weights: heads × nodes × nodes per row.
    pub weights: Vec<f32>,
    /// Values mixed by attention: tokens × embedding.
    pub mixed: Vec<f32>,
    /// Normalization before the hidden layer.
    pub before_hidden: NormTape,
    /// Outputs of the hidden layer: tokens × its width.
    pub hidden: Vec<f32>,
}

impl Tape {
    /// Returns the number of tokens of the last batch.
    pub fn tokens(&self) -> usize {
        self.types.len()
    }

    /// Computes the outputs of all nodes of a batch, and replaces the states of its tokens, tokens × width, by the next
    /// ones. `linear` computes the linear layers; everything else has the same bits on every machine.
    ///
    /// # Panics
    /// If the length of the parameters or the states does not match the shape, or if a row is too short.
    pub fn forward(
        &mut self,
        network: &GraphNetwork,
        places: &Places,
        parameters: &[f32],
        batch: Batch<'_>,
        states: &mut [f32],
        linear: Linear,
    ) {
        self.embed(network, places, parameters, batch, linear);
        if let Some(memory) = &places.memory {
            self.remember(memory, parameters, states, linear);
        }
        self.decode(network, places, parameters, states, linear);
    }

    /// Computes the normalized embeddings of all nodes of a batch.
    ///
    /// # Panics
    /// If the length of the parameters does not match the shape, or if a row is too short.
    pub fn embed(
        &mut self,
        network: &GraphNetwork,
        places: &Places,
        parameters: &[f32],
        batch: Batch<'_>,
        linear: Linear,
    ) {
        assert_eq!(parameters.len(), places.parameters(), "parameters of the network");
        self.place(network, batch);
        self.encode(network, places, parameters, batch, linear);
        for (index, block) in places.blocks.iter().enumerate() {
            self.attend(network, index, block, parameters, batch, linear);
            self.feed_forward(network, index, block, parameters, linear);
        }
        let stream = &self.stream[..self.types.len() * network.embedding];
        normalize(stream, network.embedding, &places.norm, parameters, &mut self.norm);
    }

    /// Returns the normalized embeddings: tokens × embedding.
    pub fn embeddings(&self, network: &GraphNetwork) -> &[f32] {
        &self.norm.outputs[..self.tokens() * network.embedding]
    }

    /// Replaces the states of the tokens by the next ones.
    fn remember(&mut self, memory: &MemoryPlaces, parameters: &[f32], states: &mut [f32], linear: Linear) {
        let (tokens, MemoryPlaces { input, cell }) = (self.types.len(), memory);
        assert_eq!(states.len(), tokens * cell.inputs, "states of the nodes");
        let [of_input, of_state] = self.gates.each_mut().map(|gates| sized(gates, tokens * cell.outputs));
        linear(input, parameters, &self.norm.outputs[..tokens * input.inputs], of_input);
        linear(cell, parameters, states, of_state);
        let gates = of_input.chunks_exact_mut(cell.outputs).zip(of_state.chunks_exact(cell.outputs));
        for ((of_input, of_state), state) in gates.zip(states.chunks_exact_mut(cell.inputs)) {
            step(of_input, of_state, state);
        }
    }

    /// Assigns the nodes of the batch to tokens.
    fn place(&mut self, network: &GraphNetwork, batch: Batch<'_>) {
        self.rows.clear();
        self.types.clear();
        self.places.clear();
        self.counts.clear();
        self.counts.resize(network.types.len(), 0);
        for buffers in [&mut self.inputs, &mut self.decoded, &mut self.outputs] {
            buffers.resize(network.types.len(), Vec::new());
        }
        self.blocks.resize(network.layers, BlockTape::default());
        let mut weights = 0;
        for graph in batch.graphs() {
            self.rows.push(Span { first: self.types.len(), nodes: graph.nodes(), weights });
            weights += network.heads * graph.nodes() * graph.nodes();
            for node_type in &graph.types {
                self.types.push(*node_type);
                self.places.push(self.counts[*node_type]);
                self.counts[*node_type] += 1;
            }
        }
    }

    fn encode(
        &mut self,
        network: &GraphNetwork,
        places: &Places,
        parameters: &[f32],
        batch: Batch<'_>,
        linear: Linear,
    ) {
        for (index, node) in network.types.iter().enumerate() {
            sized(&mut self.inputs[index], self.counts[index] * node.features);
        }
        let observations = batch.observations.chunks_exact(batch.width);
        for ((span, graph), observation) in self.rows.iter().zip(batch.graphs()).zip(observations) {
            for (node, node_type) in graph.types.iter().enumerate() {
                let values = &observation[graph.features[node]..graph.features[node + 1]];
                let place = self.places[span.first + node] * values.len();
                let encoder = &places.encoders[*node_type];
                let (mean, scale) = (&parameters[encoder.mean.clone()], &parameters[encoder.scale.clone()]);
                let inputs = &mut self.inputs[*node_type][place..place + values.len()];
                for (index, input) in inputs.iter_mut().enumerate() {
                    *input = ((values[index] - mean[index]) * scale[index]).clamp(-LARGEST, LARGEST);
                }
            }
        }
        let width = network.embedding;
        sized(&mut self.stream, self.types.len() * width);
        for (index, encoder) in
            places.encoders.iter().enumerate().filter(|(index, _)| self.counts[*index] > 0)
        {
            let (count, features) = (self.counts[index], encoder.layer.inputs);
            let embedded = sized(&mut self.change, count * width);
            linear(&encoder.layer, parameters, &self.inputs[index][..count * features], embedded);
            for (token, place) in tokens_of(index, &self.types, &self.places) {
                self.stream[token * width..][..width].copy_from_slice(&embedded[place * width..][..width]);
            }
        }
    }

    fn attend(
        &mut self,
        network: &GraphNetwork,
        layer: usize,
        places: &BlockPlaces,
        parameters: &[f32],
        batch: Batch<'_>,
        linear: Linear,
    ) {
        let (width, tokens) = (network.embedding, self.types.len());
        let tape = &mut self.blocks[layer];
        let stream = &mut self.stream[..tokens * width];
        normalize(stream, width, &places.before_attention, parameters, &mut tape.before_attention);
        let projections = sized(&mut tape.projections, tokens * 3 * width);
        linear(
            &places.projections,
            parameters,
            &tape.before_attention.outputs[..tokens * width],
            projections,
        );
        let mixed = sized(&mut tape.mixed, tokens * width);
        for (span, graph) in self.rows.iter().zip(batch.graphs()) {
            let (nodes, end) = (span.nodes, span.first + span.nodes);
            let count = network.heads * nodes * nodes;
            sized(&mut tape.weights, span.weights + count);
            attend(
                &projections[span.first * 3 * width..end * 3 * width],
                network.heads,
                EdgeScores {
                    relations: &graph.relations,
                    scores: &parameters[places.edges.clone()],
                    mask: network.edges.mask(layer),
                },
                &mut tape.weights[span.weights..][..count],
                &mut mixed[span.first * width..end * width],
                sized(&mut self.keys, nodes * width / network.heads),
            );
        }
        let change = sized(&mut self.change, tokens * width);
        linear(&places.mixing, parameters, mixed, change);
        stream.iter_mut().zip(change).for_each(|(sum, change)| *sum += *change);
    }

    fn feed_forward(
        &mut self,
        network: &GraphNetwork,
        layer: usize,
        places: &BlockPlaces,
        parameters: &[f32],
        linear: Linear,
    ) {
        let (width, tokens) = (network.embedding, self.types.len());
        let tape = &mut self.blocks[layer];
        let stream = &mut self.stream[..tokens * width];
        normalize(stream, width, &places.before_hidden, parameters, &mut tape.before_hidden);
        let hidden = sized(&mut tape.hidden, tokens * network.feed_forward);
        linear(&places.hidden, parameters, &tape.before_hidden.outputs[..tokens * width], hidden);
        network.activation.apply(hidden);
        let change = sized(&mut self.change, tokens * width);
        linear(&places.narrowing, parameters, hidden, change);
        stream.iter_mut().zip(change).for_each(|(sum, change)| *sum += *change);
    }

    /// Computes the outputs of all nodes from their embeddings or, with a memory, from their states: tokens × width.
    pub fn decode(
        &mut self,
        network: &GraphNetwork,
        places: &Places,
        parameters: &[f32],
        states: &[f32],
        linear: Linear,
    ) {
        let width = network.decoded();
        let inputs = if network.memory > 0 { states } else { &self.norm.outputs };
        for (index, layer) in places.decoders.iter().enumerate() {
            let count = self.counts[index];
            if count == 0 || layer.outputs == 0 {
                continue;
            }
            let decoded = sized(&mut self.decoded[index], count * width);
            for (token, place) in tokens_of(index, &self.types, &self.places) {
                decoded[place * width..][..width].copy_from_slice(&inputs[token * width..][..width]);
            }
            linear(layer, parameters, decoded, sized(&mut self.outputs[index], count * layer.outputs));
        }
    }

    /// Returns the outputs of a node of a row.
    pub fn outputs_of(&self, network: &GraphNetwork, row: usize, node: usize) -> &[f32] {
        let token = self.rows[row].first + node;
        let width = network.types[self.types[token]].outputs;
        &self.outputs[self.types[token]][self.places[token] * width..][..width]
    }
}

/// Returns the tokens of a type with their indices in it.
fn tokens_of<'a>(
    node_type: usize,
    types: &'a [usize],
    places: &'a [usize],
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let tokens = types.iter().zip(places).enumerate();
    tokens.filter(move |(_, (each, _))| **each == node_type).map(|(token, (_, place))| (token, *place))
}
