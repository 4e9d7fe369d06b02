//! The network in double precision, written straight from its definition, against which tests compare outputs and
//! gradients.

use b2b_agent::network::graph::{Graph, GraphNetwork, MemoryPlaces, NormPlaces, REACHES, RELATIONS};
use b2b_agent::network::{Activation, Layer};

use crate::nn::reference::next_state;

pub(crate) type Tokens = Vec<Vec<f64>>;

/// Returns the outputs of every node of a building. With a memory, replaces the states of the nodes by the next ones.
pub(crate) fn forward(
    network: &GraphNetwork,
    parameters: &[f64],
    graph: &Graph,
    observation: &[f64],
    states: &mut Tokens,
) -> Tokens {
    let places = network.places();
    let nodes = 0..graph.nodes();
    let encode = |node: usize| {
        let encoder = &places.encoders[graph.types[node]];
        let features = &observation[graph.features[node]..graph.features[node + 1]];
        let (mean, scale) = (&parameters[encoder.mean.clone()], &parameters[encoder.scale.clone()]);
        let scaled =
            features.iter().zip(mean.iter().zip(scale)).map(|(value, (mean, scale))| (value - mean) * scale);
        linear(&encoder.layer, parameters, &scaled.collect::<Vec<_>>())
    };
    let mut stream: Tokens = nodes.clone().map(encode).collect();
    for (index, block) in places.blocks.iter().enumerate() {
        let projected: Tokens = stream
            .iter()
            .map(|token| {
                linear(&block.projections, parameters, &norm(&block.before_attention, parameters, token))
            })
            .collect();
        let edges = &parameters[block.edges.clone()];
        let mask = network.edges.mask(index);
        for node in nodes.clone() {
            let mixed = attend(network, &projected, node, graph, edges, mask);
            add(&mut stream[node], &linear(&block.mixing, parameters, &mixed));
        }
        for token in &mut stream {
            let mut hidden =
                linear(&block.hidden, parameters, &norm(&block.before_hidden, parameters, token));
            hidden.iter_mut().for_each(|value| match network.activation {
                Activation::Tanh => *value = value.tanh(),
                Activation::Relu => *value = value.max(0.0),
            });
            add(token, &linear(&block.narrowing, parameters, &hidden));
        }
    }
    let mut decoded: Tokens = stream.iter().map(|token| norm(&places.norm, parameters, token)).collect();
    if let Some(memory) = &places.memory {
        remember(memory, parameters, states, &mut decoded);
    }
    let decode =
        |(node, token): (usize, &Vec<f64>)| linear(&places.decoders[graph.types[node]], parameters, token);
    decoded.iter().enumerate().map(decode).collect()
}

/// Replaces the states of the nodes by the next ones, which also become the embeddings of the nodes.
fn remember(memory: &MemoryPlaces, parameters: &[f64], states: &mut Tokens, embeddings: &mut Tokens) {
    let MemoryPlaces { input, cell } = memory;
    for (state, token) in states.iter_mut().zip(embeddings) {
        next_state(&linear(input, parameters, token), &linear(cell, parameters, state), state);
        token.clone_from(state);
    }
}

fn attend(
    network: &GraphNetwork,
    projected: &Tokens,
    node: usize,
    graph: &Graph,
    edges: &[f64],
    mask: bool,
) -> Vec<f64> {
    let (embedding, heads) = (network.embedding, network.heads);
    let width = embedding / heads;
    let mut mixed = Vec::new();
    for head in 0..heads {
        let part =
            |token: usize, which: usize| &projected[token][which * embedding + head * width..][..width];
        let weight = |other: usize| {
            let relation = graph.relations[node * graph.nodes() + other];
            if mask && relation & REACHES == 0 {
                return 0.0;
            }
            let product: f64 = part(node, 0).iter().zip(part(other, 1)).map(|(a, b)| a * b).sum();
            let of_edge = |kind: usize| match relation & (1 << kind) != 0 && !edges.is_empty() {
                true => edges[head * RELATIONS + kind],
                false => 0.0,
            };
            (product / (width as f64).sqrt() + (0..RELATIONS).map(of_edge).sum::<f64>()).exp()
        };
        let weights: Vec<f64> = (0..graph.nodes()).map(weight).collect();
        let total: f64 = weights.iter().sum();
        for place in 0..width {
            let values =
                weights.iter().enumerate().map(|(other, weight)| weight / total * part(other, 2)[place]);
            mixed.push(values.sum());
        }
    }
    mixed
}

fn linear(layer: &Layer, parameters: &[f64], input: &[f64]) -> Vec<f64> {
    let mut output = parameters[layer.biases.clone()].to_vec();
    for (value, row) in input.iter().zip(parameters[layer.weights.clone()].chunks(layer.outputs.max(1))) {
        output.iter_mut().zip(row).for_each(|(sum, weight)| *sum += value * weight);
    }
    output
}

fn norm(places: &NormPlaces, parameters: &[f64], token: &[f64]) -> Vec<f64> {
    let mean = token.iter().sum::<f64>() / token.len() as f64;
    let variance = token.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / token.len() as f64;
    let factors = parameters[places.gain.clone()].iter().zip(&parameters[places.bias.clone()]);
    let normed = token.iter().map(|value| (value - mean) / (variance + 1e-5).sqrt());
    normed.zip(factors).map(|(value, (gain, bias))| value * gain + bias).collect()
}

fn add(sums: &mut [f64], values: &[f64]) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
}
