//! Layout of the parameters of a graph network.

use std::ops::Range;

use b2b_building::morphology::NodeType;

use super::network::{Edges, GraphNetwork};
use super::topology::RELATIONS;
use crate::network::recurrent::GATES;
use crate::network::{Layer, Tensor};

/// Ranges of the parameters of a graph network in one slice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// Encoder of each type.
    pub encoders: Vec<EncoderPlaces>,
    /// Layers of the transformer.
    pub blocks: Vec<BlockPlaces>,
    /// Normalization after the transformer.
    pub norm: NormPlaces,
    /// The memory of the nodes, if they have one.
    pub memory: Option<MemoryPlaces>,
    /// Decoder of each type.
    pub decoders: Vec<Layer>,
    parameters: usize,
}

/// Ranges of the encoder of a type. Mean and scale are not learned: they are statistics of the features of all nodes of
/// the type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncoderPlaces {
    /// Mean of each feature.
    pub mean: Range<usize>,
    /// One over the standard deviation of each feature.
    pub scale: Range<usize>,
    /// The layer.
    pub layer: Layer,
}

/// Ranges of a transformer layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockPlaces {
    /// Normalization before the attention.
    pub before_attention: NormPlaces,
    /// Queries, keys and values of all heads.
    pub projections: Layer,
    /// Scores of edges, heads × kinds of edges; empty without [`Edges::Bias`].
    pub edges: Range<usize>,
    /// The linear layer after the attention.
    pub mixing: Layer,
    /// Normalization before the hidden layer.
    pub before_hidden: NormPlaces,
    /// The hidden layer.
    pub hidden: Layer,
    /// The linear layer from the hidden layer to the embedding.
    pub narrowing: Layer,
}

/// Ranges of a gated recurrent unit: see [`recurrent`](crate::network::recurrent). All nodes share it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemoryPlaces {
    /// From the normalized embedding to the inputs of the gates.
    pub input: Layer,
    /// From the state to the inputs of the gates.
    pub cell: Layer,
}

/// Ranges of a layer normalization.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NormPlaces {
    /// Gain of each component.
    pub gain: Range<usize>,
    /// Bias of each component.
    pub bias: Range<usize>,
}

/// Allocates consecutive ranges.
struct Allocation(usize);

impl Allocation {
    fn take(&mut self, count: usize) -> Range<usize> {
        let start = self.0;
        self.0 += count;
        start..self.0
    }

    fn layer(&mut self, inputs: usize, outputs: usize) -> Layer {
        Layer { inputs, outputs, weights: self.take(inputs * outputs), biases: self.take(outputs) }
    }

    fn norm(&mut self, width: usize) -> NormPlaces {
        NormPlaces { gain: self.take(width), bias: self.take(width) }
    }

    fn memory(&mut self, inputs: usize, state: usize) -> MemoryPlaces {
        MemoryPlaces { input: self.layer(inputs, GATES * state), cell: self.layer(state, GATES * state) }
    }
}

impl GraphNetwork {
    /// Returns the ranges of the parameters.
    pub fn places(&self) -> Places {
        let Self { types, embedding, heads, layers, feed_forward, edges, memory, .. } = self;
        let (width, mut at) = (*embedding, Allocation(0));
        let encoders = types
            .iter()
            .map(|node| EncoderPlaces {
                mean: at.take(node.features),
                scale: at.take(node.features),
                layer: at.layer(node.features, width),
            })
            .collect();
        let scores = if *edges == Edges::Bias { heads * RELATIONS } else { 0 };
        let blocks = (0..*layers)
            .map(|_| BlockPlaces {
                before_attention: at.norm(width),
                projections: at.layer(width, 3 * width),
                edges: at.take(scores),
                mixing: at.layer(width, width),
                before_hidden: at.norm(width),
                hidden: at.layer(width, *feed_forward),
                narrowing: at.layer(*feed_forward, width),
            })
            .collect();
        let norm = at.norm(width);
        let memory = (*memory > 0).then(|| at.memory(width, *memory));
        let decoders = types.iter().map(|node| at.layer(self.decoded(), node.outputs)).collect();
        Places { encoders, blocks, norm, memory, decoders, parameters: at.0 }
    }
}

impl Places {
    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Returns the normalizations.
    pub fn norms(&self) -> impl Iterator<Item = &NormPlaces> {
        let of_blocks = self.blocks.iter().flat_map(|block| [&block.before_attention, &block.before_hidden]);
        of_blocks.chain([&self.norm])
    }

    /// Returns the tensors, which cover every parameter once.
    pub fn tensors(&self) -> Vec<Tensor> {
        let mut tensors = Vec::new();
        let vector = |name: String, place: &Range<usize>| Tensor {
            name,
            sizes: vec![place.len()],
            place: place.clone(),
        };
        let norm = |name: &str, norm: &NormPlaces| {
            [vector(format!("{name}.gain"), &norm.gain), vector(format!("{name}.bias"), &norm.bias)]
        };
        let name_of = |index: usize| NodeType::ALL[index].name().replace(' ', "_");
        for (index, encoder) in self.encoders.iter().enumerate() {
            let name = format!("encoders.{}", name_of(index));
            tensors.push(vector(format!("{name}.mean"), &encoder.mean));
            tensors.push(vector(format!("{name}.scale"), &encoder.scale));
            tensors.extend(encoder.layer.tensors(&name));
        }
        for (index, block) in self.blocks.iter().enumerate() {
            let name = |part: &str| format!("layers.{index}.{part}");
            tensors.extend(norm(&name("before_attention"), &block.before_attention));
            tensors.extend(block.projections.tensors(&name("projections")));
            if !block.edges.is_empty() {
                tensors.push(vector(name("edges"), &block.edges));
            }
            tensors.extend(block.mixing.tensors(&name("mixing")));
            tensors.extend(norm(&name("before_hidden"), &block.before_hidden));
            tensors.extend(block.hidden.tensors(&name("hidden")));
            tensors.extend(block.narrowing.tensors(&name("narrowing")));
        }
        tensors.extend(norm("norm", &self.norm));
        if let Some(MemoryPlaces { input, cell }) = &self.memory {
            tensors.extend(input.tensors("memory.input").into_iter().chain(cell.tensors("memory.cell")));
        }
        let decoders = self.decoders.iter().enumerate();
        tensors.extend(
            decoders.flat_map(|(index, layer)| layer.tensors(&format!("decoders.{}", name_of(index)))),
        );
        tensors
    }
}
