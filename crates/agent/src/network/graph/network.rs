//! The shape of a graph network.

use serde::{Deserialize, Serialize};

use crate::network::Activation;

/// The shape of a graph network. By default that of the paper's experiment: an embedding of 64, 4 heads, 2 layers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GraphNetwork {
    /// Node types, in the order of [`NodeType::ALL`](b2b_building::morphology::NodeType::ALL).
    pub types: Vec<NodeWidths>,
    /// Width of the embedding of a node.
    pub embedding: usize,
    /// Attention heads, which divide the embedding evenly.
    pub heads: usize,
    /// Layers of the transformer.
    pub layers: usize,
    /// Width of the hidden layer behind each attention.
    pub feed_forward: usize,
    /// Activation of these hidden layers.
    pub activation: Activation,
    /// How attention uses the edges.
    pub edges: Edges,
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
    /// Nothing, as in Amorpheus.
    #[default]
    None,
    /// A learned number is added to the score of every pair of nodes with an edge: one for each layer, head and kind of edge.
    Bias,
    /// A node attends to itself, to nodes that it has an edge with, and to weather, calendar and energy, which attend to all.
    Mask,
    /// As `mask` in every other layer from the first on, and as `none` in the rest (Sferrazza et al. 2024, Body Transformer).
    Mixed,
}

impl Edges {
    /// Returns whether the attention of a layer is along edges alone.
    pub fn mask(self, layer: usize) -> bool {
        match self {
            Self::None | Self::Bias => false,
            Self::Mask => true,
            Self::Mixed => layer.is_multiple_of(2),
        }
    }
}
