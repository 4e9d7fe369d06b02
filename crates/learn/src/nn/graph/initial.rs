//! Initialization of graph networks.

use std::f32::consts::SQRT_2;

use b2b_agent::network::graph::{GraphNetwork, MemoryPlaces};

use crate::nn::cell;
use crate::nn::orthogonal::write_weights;
use crate::random::RandomStream;

/// Standard deviation of initial encoder biases; they alone distinguish node types without features.
const TYPE_DEVIATION: f32 = 0.5;

/// Returns initial parameters: orthogonal matrices, scaled by √2 in the encoders and the hidden layers, by `last` in
/// the decoders and, in layers that add to the embedding, by 1/√(number of such layers) (Radford et al. 2019). Biases
/// are 0, except in the encoders and in a memory, which remembers for up to `memory` steps.
pub fn initialize(network: &GraphNetwork, last: f32, memory: usize, random: &mut RandomStream) -> Vec<f32> {
    let places = network.places();
    let mut parameters = vec![0.0; places.parameters()];
    for encoder in &places.encoders {
        parameters[encoder.scale.clone()].fill(1.0);
        if encoder.layer.inputs > 0 {
            let weights = &mut parameters[encoder.layer.weights.clone()];
            write_weights(&encoder.layer, SQRT_2, random, weights);
        }
        let biases = &mut parameters[encoder.layer.biases.clone()];
        biases.iter_mut().for_each(|bias| *bias = TYPE_DEVIATION * random.normal() as f32);
    }
    let added = 1.0 / (2.0 * network.layers as f32).sqrt();
    for block in &places.blocks {
        for (layer, gain) in [
            (&block.projections, 1.0),
            (&block.mixing, added),
            (&block.hidden, SQRT_2),
            (&block.narrowing, added),
        ] {
            write_weights(layer, gain, random, &mut parameters[layer.weights.clone()]);
        }
    }
    for norm in places.norms() {
        parameters[norm.gain.clone()].fill(1.0);
    }
    if let Some(MemoryPlaces { input, cell }) = &places.memory {
        write_weights(input, 1.0, random, &mut parameters[input.weights.clone()]);
        cell::initialize(cell, memory, random, &mut parameters);
    }
    for layer in places.decoders.iter().filter(|layer| layer.outputs > 0) {
        write_weights(layer, last, random, &mut parameters[layer.weights.clone()]);
    }
    parameters
}
