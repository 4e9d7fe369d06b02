//! The kind of network of a run.

use b2b_agent::network::{Activation, Edges, GraphNetwork};
use b2b_agent::{Interface, NodeForm, NodeSpaces};
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::limits::{check_counts, require};

/// The kind of network of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum PolicyConfig {
    /// Multilayer perceptrons, for buildings with the same observation and actuators: see
    /// [`PpoConfig`](crate::ppo::PpoConfig) and [`SacConfig`](crate::sac::SacConfig) for their layers.
    #[default]
    Flat,
    /// Recurrent networks, which remember earlier steps, for buildings as above: PPO's hidden layers come before a
    /// gated recurrent unit.
    Recurrent(RecurrentPolicy),
    /// Graph networks, for buildings of any types.
    Graph(GraphPolicy),
}

/// The recurrent networks of a run: actor and critic each have a gated recurrent unit, between their hidden layers and
/// their last layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecurrentPolicy {
    /// Width of the state. Default 64.
    pub width: usize,
    /// Steps of a rollout through which gradients are propagated at a time; divides the steps of a rollout. Default 96.
    pub sequence: usize,
    /// Consecutive episodes in a building that the state spans. Default 1.
    pub memory_episodes: u32,
}

impl Default for RecurrentPolicy {
    fn default() -> Self {
        Self { width: 64, sequence: 96, memory_episodes: 1 }
    }
}

/// The graph networks of a run: actor and critic have the same shape, except for their outputs.
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
    /// Width of the state of each node, which a gated recurrent unit between the transformer and the outputs keeps.
    /// Default 0: no memory.
    pub memory: usize,
    /// With a memory, like [`RecurrentPolicy::sequence`]. Default 48.
    pub sequence: usize,
    /// With a memory, like [`RecurrentPolicy::memory_episodes`]. Default 1.
    pub memory_episodes: u32,
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
            memory: 0,
            sequence: 48,
            memory_episodes: 1,
        }
    }
}

impl PolicyConfig {
    /// Returns how a graph network observes a building.
    pub(crate) fn nodes(&self) -> Option<NodeForm> {
        match self {
            Self::Flat | Self::Recurrent(_) => None,
            Self::Graph(policy) => Some(NodeForm { attributes: policy.attributes }),
        }
    }

    /// Returns whether the networks are graph networks.
    pub(crate) fn is_graph(&self) -> bool {
        matches!(self, Self::Graph(_))
    }

    /// Returns the memory of the networks, if they have one.
    pub(crate) fn recurrent(&self) -> Option<RecurrentPolicy> {
        match self {
            Self::Flat => None,
            Self::Recurrent(policy) => Some(*policy),
            Self::Graph(policy) => policy.recurrent(),
        }
    }

    /// Checks the values.
    pub(crate) fn check(&self) -> Result<()> {
        self.recurrent().map_or(Ok(()), |policy| policy.check())?;
        match self {
            Self::Flat | Self::Recurrent(_) => Ok(()),
            Self::Graph(policy) => policy.check(),
        }
    }
}

impl RecurrentPolicy {
    /// Checks that the steps of a rollout, an option, are whole sequences.
    pub(crate) fn check_steps(&self, option: &str, steps: usize) -> Result<()> {
        let Self { sequence, .. } = *self;
        require(sequence >= 1 && steps.is_multiple_of(sequence), || {
            format!("`{option}` is {steps}; expected a multiple of `policy.sequence`, {sequence}")
        })
    }

    /// Checks the values.
    fn check(&self) -> Result<()> {
        let Self { width, sequence, memory_episodes } = *self;
        check_counts([
            ("policy.width", width),
            ("policy.sequence", sequence),
            ("policy.memory_episodes", memory_episodes as usize),
        ])
    }
}

impl GraphPolicy {
    /// Returns the memory, if there is one.
    fn recurrent(&self) -> Option<RecurrentPolicy> {
        let Self { memory: width, sequence, memory_episodes, .. } = *self;
        (width > 0).then_some(RecurrentPolicy { width, sequence, memory_episodes })
    }

    /// Checks the values of all but the memory.
    fn check(&self) -> Result<()> {
        let Self { embedding, heads, layers, feed_forward, memory, .. } = *self;
        check_counts([
            ("policy.embedding", embedding),
            ("policy.heads", heads),
            ("policy.layers", layers),
            ("policy.feed_forward", feed_forward),
        ])?;
        require(embedding.is_multiple_of(heads), || {
            format!("`policy.heads` is {heads}; expected a divisor of the embedding, {embedding}")
        })?;
        let unused = Self::default();
        for (option, value, default) in [
            ("sequence", self.sequence, unused.sequence),
            ("memory_episodes", self.memory_episodes as usize, unused.memory_episodes as usize),
        ] {
            require(memory > 0 || value == default, || {
                format!(
                    "`policy.{option}` is {value} and `policy.memory` is 0; set the width of the memory, such as 64"
                )
            })?;
        }
        Ok(())
    }

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
            memory: self.memory,
        }
    }
}
