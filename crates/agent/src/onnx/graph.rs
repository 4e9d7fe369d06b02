//! The ONNX file of a graph network in one building.
//!
//! Nodes are in the order of their types. Values between the layers have the shape [batch, nodes, embedding].

use super::file::{File, list, number, whole};
use super::plain::{NEXT_STATE, activation, columns, gated_unit, last};
use crate::network::graph::{BlockPlaces, EPSILON, EdgeScores, LARGEST, MemoryPlaces, NormPlaces};
use crate::network::{Actor, Graph, GraphNetwork, Layer};
use crate::observation::LinearFeature;

/// Score of a pair of nodes without attention; its exponential is 0.
const NO_ATTENTION: f32 = -1e9;
/// Extent of a shape that follows from the others, -1 in the file.
const REST: usize = usize::MAX;

/// Returns the file for a building whose nodes have these features, one node after another.
pub(super) fn file(
    actor: &Actor,
    network: &GraphNetwork,
    graph: &Graph,
    features: &[LinearFeature],
    width: usize,
) -> Vec<u8> {
    let mut order: Vec<usize> = (0..graph.nodes()).collect();
    order.sort_by_key(|node| graph.types[*node]);
    let mut export = GraphExport { file: File::default(), actor, network, graph, order };
    let mut stream = export.encode(features);
    let places = network.places();
    for (index, block) in places.blocks.iter().enumerate() {
        stream = export.attend(&stream, index, block);
        stream = export.feed_forward(&stream, block);
    }
    let normed = export.normalize(&stream, &places.norm);
    let (mut inputs, mut outputs) = (vec![("observation", width)], vec![("action", graph.actions.len())]);
    let decoded = match &places.memory {
        None => normed,
        Some(memory) => {
            let state = graph.nodes() * network.memory;
            inputs.push(("state", state));
            outputs.push((NEXT_STATE, state));
            export.remember(&normed, memory)
        }
    };
    export.decode(&decoded);
    export.file.finish(&inputs, &outputs)
}

struct GraphExport<'a> {
    file: File,
    actor: &'a Actor,
    network: &'a GraphNetwork,
    graph: &'a Graph,
    /// Nodes of the building in the order of the file.
    order: Vec<usize>,
}

impl GraphExport<'_> {
    /// Returns the nodes of a type, and where they begin in the order of the file.
    fn nodes_of(&self, node_type: usize) -> (usize, Vec<usize>) {
        let is_earlier = |node: &&usize| self.graph.types[**node] < node_type;
        let is_own = |node: &&usize| self.graph.types[**node] == node_type;
        let first = self.order.iter().filter(is_earlier).count();
        (first, self.order.iter().filter(is_own).copied().collect())
    }

    fn encode(&mut self, features: &[LinearFeature]) -> String {
        let [lowest, highest] = [-LARGEST, LARGEST].map(|limit| self.file.tensor(&[], &[limit]));
        let mut embedded = Vec::new();
        for (node_type, encoder) in self.network.places().encoders.iter().enumerate() {
            let (_, nodes) = self.nodes_of(node_type);
            if nodes.is_empty() {
                continue;
            }
            let parameters = &self.actor.parameters;
            let (mean, inverse) = (&parameters[encoder.mean.clone()], &parameters[encoder.scale.clone()]);
            let (mut slots, mut scales, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
            for node in &nodes {
                let own = &features[self.graph.features[*node]..self.graph.features[node + 1]];
                for ((feature, mean), inverse) in own.iter().zip(mean).zip(inverse) {
                    let inverse = f64::from(*inverse);
                    slots.push(feature.slot);
                    scales.push((feature.scale * inverse) as f32);
                    offsets.push(((feature.offset - f64::from(*mean)) * inverse) as f32);
                }
            }
            let shape = [nodes.len(), mean.len()];
            let slots = self.file.integers(&shape, &slots);
            let (scales, offsets) = (self.file.tensor(&shape, &scales), self.file.tensor(&shape, &offsets));
            let values = self.file.operator("Gather", &["observation", &slots], &[whole("axis", 1)]);
            let values = self.file.operator("Mul", &[&values, &scales], &[]);
            let values = self.file.operator("Add", &[&values, &offsets], &[]);
            let values = self.file.operator("Clip", &[&values, &lowest, &highest], &[]);
            embedded.push(self.linear(&values, &encoder.layer, 0..encoder.layer.outputs));
        }
        self.concatenate(&embedded)
    }

    fn attend(&mut self, stream: &str, layer: usize, block: &BlockPlaces) -> String {
        let GraphNetwork { embedding, heads, .. } = *self.network;
        let (nodes, width) = (self.order.len(), embedding / heads);
        let normed = self.normalize(stream, &block.before_attention);
        let by_head = self.file.integers(&[4], &[0, nodes, heads, width]);
        let [queries, keys, values] = [0, 1, 2].map(|part| {
            let columns = part * embedding..(part + 1) * embedding;
            let projected = self.linear(&normed, &block.projections, columns);
            let split = self.file.operator("Reshape", &[&projected, &by_head], &[]);
            // Keys have the nodes last, so that queries can be multiplied by them.
            let order = if part == 1 { [0, 2, 3, 1] } else { [0, 2, 1, 3] };
            self.file.operator("Transpose", &[&split], &[list("perm", &order)])
        });
        let scale = self.file.tensor(&[], &[1.0 / (width as f32).sqrt()]);
        let queries = self.file.operator("Mul", &[&queries, &scale], &[]);
        let scores = self.file.operator("MatMul", &[&queries, &keys], &[]);
        let of_edges = self.edge_scores(layer, block);
        let of_edges = self.file.tensor(&[heads, nodes, nodes], &of_edges);
        let scores = self.file.operator("Add", &[&scores, &of_edges], &[]);
        let weights = self.file.operator("Softmax", &[&scores], &[whole("axis", 3)]);
        let mixed = self.file.operator("MatMul", &[&weights, &values], &[]);
        let mixed = self.file.operator("Transpose", &[&mixed], &[list("perm", &[0, 2, 1, 3])]);
        let mixed = self.reshape(&mixed, &[0, nodes, embedding]);
        let change = self.linear(&mixed, &block.mixing, 0..embedding);
        self.file.operator("Add", &[stream, &change], &[])
    }

    /// Returns the edge scores added to attention: heads × nodes × nodes.
    fn edge_scores(&self, layer: usize, block: &BlockPlaces) -> Vec<f32> {
        let nodes = self.order.len();
        let pairs = self.order.iter().flat_map(|from| self.order.iter().map(move |to| from * nodes + to));
        let relations: Vec<u8> = pairs.map(|pair| self.graph.relations[pair]).collect();
        let edges = EdgeScores {
            relations: &relations,
            scores: &self.actor.parameters[block.edges.clone()],
            mask: self.network.edges.mask(layer),
        };
        let mut scores = vec![0.0; self.network.heads * relations.len()];
        for (head, scores) in scores.chunks_exact_mut(relations.len()).enumerate() {
            edges.add(head, &relations, scores);
        }
        // Runtimes differ in their treatment of -∞.
        scores.iter_mut().for_each(|score| *score = score.max(NO_ATTENTION));
        scores
    }

    fn feed_forward(&mut self, stream: &str, block: &BlockPlaces) -> String {
        let normed = self.normalize(stream, &block.before_hidden);
        let sums = self.linear(&normed, &block.hidden, 0..block.hidden.outputs);
        let hidden = self.file.operator(activation(self.network.activation), &[&sums], &[]);
        let change = self.linear(&hidden, &block.narrowing, 0..block.narrowing.outputs);
        self.file.operator("Add", &[stream, &change], &[])
    }

    /// Adds the memory, and returns the next states: [batch, nodes, width].
    fn remember(&mut self, normed: &str, memory: &MemoryPlaces) -> String {
        let (MemoryPlaces { input, cell }, nodes) = (memory, self.order.len());
        // The unit's batch is the nodes of all rows.
        let sequence = self.reshape(normed, &[1, REST, input.inputs]);
        let state = self.reshape("state", &[1, REST, cell.inputs]);
        let parameters = &self.actor.parameters[..];
        let states = gated_unit(&mut self.file, [&sequence, &state], (input, parameters), (cell, parameters));
        let flat = self.file.integers(&[2], &[REST, nodes * cell.inputs]);
        self.file.named("Reshape", &[&states, &flat], &[], NEXT_STATE);
        self.reshape(&states, &[REST, nodes, cell.inputs])
    }

    fn reshape(&mut self, values: &str, shape: &[usize]) -> String {
        let shape = self.file.integers(&[shape.len()], shape);
        self.file.operator("Reshape", &[values, &shape], &[])
    }

    fn decode(&mut self, decoded: &str) {
        // Start of the outputs of each node.
        let (mut places, mut outputs, mut count) = (vec![0; self.graph.nodes()], Vec::new(), 0);
        for (node_type, layer) in self.network.places().decoders.iter().enumerate() {
            let (first, nodes) = self.nodes_of(node_type);
            if nodes.is_empty() || layer.outputs == 0 {
                continue;
            }
            let tokens: Vec<usize> = (first..first + nodes.len()).collect();
            let tokens = self.file.integers(&[nodes.len()], &tokens);
            let own = self.file.operator("Gather", &[decoded, &tokens], &[whole("axis", 1)]);
            let own = self.linear(&own, layer, 0..layer.outputs);
            let width = nodes.len() * layer.outputs;
            outputs.push(self.reshape(&own, &[0, width]));
            for node in nodes {
                places[node] = count;
                count += layer.outputs;
            }
        }
        let all = self.concatenate(&outputs);
        let actions = &self.graph.actions;
        let chosen: Vec<usize> = actions.iter().map(|action| places[action.node] + action.output).collect();
        let chosen = self.file.integers(&[actions.len()], &chosen);
        let chosen = self.file.operator("Gather", &[&all, &chosen], &[whole("axis", 1)]);
        self.file.named(last(self.actor), &[&chosen], &[], "action");
    }

    /// Adds the columns `of` of a layer.
    fn linear(&mut self, input: &str, layer: &Layer, of: std::ops::Range<usize>) -> String {
        let parameters = &self.actor.parameters;
        let weights = self.file.tensor(&[layer.inputs, of.len()], &columns(parameters, layer, of.clone()));
        let biases = self.file.tensor(&[of.len()], &parameters[layer.biases.clone()][of]);
        let product = self.file.operator("MatMul", &[input, &weights], &[]);
        self.file.operator("Add", &[&product, &biases], &[])
    }

    fn normalize(&mut self, input: &str, places: &NormPlaces) -> String {
        let [gain, bias] = [&places.gain, &places.bias]
            .map(|place| self.file.tensor(&[place.len()], &self.actor.parameters[place.clone()]));
        let attributes = [whole("axis", 2), number("epsilon", EPSILON)];
        self.file.operator("LayerNormalization", &[input, &gain, &bias], &attributes)
    }

    fn concatenate(&mut self, values: &[String]) -> String {
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        self.file.operator("Concat", &values, &[whole("axis", 1)])
    }
}
