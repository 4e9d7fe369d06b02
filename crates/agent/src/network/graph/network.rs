//! The shape of a graph network.

use serde::{Deserialize, Serialize};

use crate::network::Activation;

/// The shape of a graph network. The paper's has an embedding of 64, 4 heads and 2 layers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GraphNetwork {
    /// Node types, in the order of [`NodeType::ALL`](b2b_building::morphology::NodeType::ALL).
    pub types: Vec<NodeWidths>,
    /// Width of the embedding of a node.
    pub embedding: usize,
    /// Number of attention heads; divides the embedding.
    pub heads: usize,
    /// Layers of the transformer.
    pub layers: usize,
    /// Width of the hidden layer after each attention.
    pub feed_forward: usize,
    /// Activation of these hidden layers.
    pub activation: Activation,
    /// How attention uses the edges.
    pub edges: Edges,
    /// Width of the state of each node, which a gated recurrent unit after the transformer keeps; 0 for no memory.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub memory: usize,
}

impl GraphNetwork {
    /// Returns the width of the inputs of the decoders: of a node's state or, without a memory, of its embedding.
    pub fn decoded(&self) -> usize {
        if self.memory > 0 { self.memory } else { self.embedding }
    }
}

fn is_zero(width: &usize) -> bool {
    *width == 0
}

/// The widths of a node type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodeWidths {
    /// Features of a node.
    pub features: usize,
    /// Outputs of a node.
    pub outputs: usize,
}

/// How attention uses the edges of a building.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Edges {
    /// Edges are not used, as in Amorpheus.
    #[default]
    None,
    /// Adds a learned bias to the score of every pair of nodes with an edge: one per layer, head and kind of edge.
    Bias,
    /// A node attends to itself, to its neighbors, and to weather, calendar and energy, which attend to all nodes.
    Mask,
    /// `mask` in the first, third, ... layer and `none` in the others (Sferrazza et al. 2024, Body Transformer).
    Mixed,
}

impl Edges {
    /// Returns whether a layer attends only along edges.
    pub fn mask(self, layer: usize) -> bool {
        match self {
            Self::None | Self::Bias => false,
            Self::Mask => true,
            Self::Mixed => layer.is_multiple_of(2),
        }
    }
}
