//! Shapes of networks.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{GraphNetwork, Mlp, Recurrent};

/// The shape of an actor's network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Shape {
    /// A multilayer perceptron, for buildings with the same spaces.
    Mlp(Mlp),
    /// A recurrent network, for buildings with the same spaces.
    Recurrent(Recurrent),
    /// A graph network, for every building whose node types it was trained with.
    Graph(GraphNetwork),
}

/// A tensor among the parameters of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tensor {
    /// Name, such as `0.weight`.
    pub name: String,
    /// Sizes: inputs and outputs for a matrix.
    pub sizes: Vec<usize>,
    /// Range in the parameters.
    pub place: Range<usize>,
}

impl Shape {
    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        match self {
            Self::Mlp(mlp) => mlp.parameters(),
            Self::Recurrent(network) => network.parameters(),
            Self::Graph(network) => network.places().parameters(),
        }
    }

    /// Returns the tensors, which cover every parameter once.
    pub fn tensors(&self) -> Vec<Tensor> {
        match self {
            Self::Mlp(mlp) => mlp.tensors(""),
            Self::Recurrent(network) => network.tensors(),
            Self::Graph(network) => network.places().tensors(),
        }
    }

    /// Returns the multilayer perceptron, if it is one.
    pub fn mlp(&self) -> Option<&Mlp> {
        match self {
            Self::Mlp(mlp) => Some(mlp),
            Self::Recurrent(_) | Self::Graph(_) => None,
        }
    }

    /// Returns the recurrent network, if it is one.
    pub fn recurrent(&self) -> Option<&Recurrent> {
        match self {
            Self::Recurrent(network) => Some(network),
            Self::Mlp(_) | Self::Graph(_) => None,
        }
    }

    /// Returns the width of the state kept from step to step, per node in a graph network; 0 without a memory.
    pub fn state(&self) -> usize {
        match self {
            Self::Mlp(_) => 0,
            Self::Recurrent(network) => network.state(),
            Self::Graph(network) => network.memory,
        }
    }

    /// Returns the graph network, if it is one.
    pub fn graph(&self) -> Option<&GraphNetwork> {
        match self {
            Self::Mlp(_) | Self::Recurrent(_) => None,
            Self::Graph(network) => Some(network),
        }
    }
}
