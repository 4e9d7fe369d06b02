//! The kind of network of a run.

use b2b_agent::network::{Activation, Edges, GraphNetwork};
use b2b_agent::{Interface, NodeForm, NodeSpaces};
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::limits::{check_counts, require};

/// The kind of network of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Policy {
    /// Multilayer perceptrons, for buildings with the same observation and actuators: see [`PpoConfig`](crate::ppo::PpoConfig) and
    /// [`SacConfig`](crate::sac::SacConfig) for their layers.
    #[default]
    Flat,
    /// Graph networks, for buildings of any types.
    Graph(GraphPolicy),
}

/// The graph networks of a run: actor and critic have the same shape.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GraphPolicy {
    /// Width of the embedding of a node. Default 64.
    pub embedding: usize,
    /// Heads of attention, which share the embedding evenly. Default 4.
    pub heads: usize,
    /// Layers of the transformer. Default 2.
    pub layers: usize,
    /// Width of the hidden layer after each attention. Default 128.
    pub feed_forward: usize,
    /// Activation of these hidden layers. Default relu.
    pub activation: Activation,
    /// How attention uses the edges of a building: `none`, `bias`, `mask` or `mixed`. Default none.
    pub edges: Edges,
    /// Whether nodes have their attributes as features, and the weather node the building's attributes. Default false.
    pub attributes: bool,
    /// Whether features have mean 0 and deviation 1 over all nodes of a type. Default true.
    pub normalize: bool,
}

impl Default for GraphPolicy {
    fn default() -> Self {
        Self {
            embedding: 64,
            heads: 4,
            layers: 2,
            feed_forward: 128,
            activation: Activation::Relu,
            edges: Edges::None,
            attributes: false,
            normalize: true,
        }
    }
}

impl Policy {
    /// Returns how a graph network observes a building.
    pub(crate) fn nodes(&self) -> Option<NodeForm> {
        match self {
            Self::Flat => None,
            Self::Graph(policy) => Some(NodeForm { attributes: policy.attributes }),
        }
    }

    /// Checks the values.
    pub(crate) fn check(&self) -> Result<()> {
        let Self::Graph(policy) = self else { return Ok(()) };
        let GraphPolicy { embedding, heads, layers, feed_forward, .. } = *policy;
        check_counts([
            ("policy.embedding", embedding),
            ("policy.heads", heads),
            ("policy.layers", layers),
            ("policy.feed_forward", feed_forward),
        ])?;
        require(embedding.is_multiple_of(heads), || {
            format!("`policy.heads` is {heads}; expected a divisor of the embedding, {embedding}")
        })
    }
}

impl GraphPolicy {
    /// Returns the shape of the actor of an agent, whose outputs are its actions.
    pub fn network(&self, interface: Interface) -> GraphNetwork {
        GraphNetwork {
            types: NodeSpaces::of(interface).widths(),
            embedding: self.embedding,
            heads: self.heads,
            layers: self.layers,
            feed_forward: self.feed_forward,
            activation: self.activation,
            edges: self.edges,
        }
    }
}
