//! A building as the input of a graph network.

use b2b_building::morphology::{EdgeKind, NodeType};

use crate::plan::NodePlan;

/// Number of kinds of edges, counting both directions: adjacent, serves, is served by, controls, is controlled by.
pub const RELATIONS: usize = 5;
/// Bit of a pair of nodes: the first may attend to the second even if attention is limited to edges.
pub const REACHES: u8 = 1 << 7;

/// The nodes of a building: types, features, actions and edges.
///
/// A row of observations has the features of the nodes one after another; a row of actions follows the order of the
/// building's actuators or supervisory points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Graph {
    /// Name of each node.
    pub names: Vec<String>,
    /// Type of each node, as an index into the network's types.
    pub types: Vec<usize>,
    /// Start of the features of each node in a row, followed by the width of a row.
    pub features: Vec<usize>,
    /// Node and output of each action.
    pub actions: Vec<ActionPlace>,
    /// Edges from the node of each row to the node of each column: one bit per kind ([`RELATIONS`]), and [`REACHES`].
    pub relations: Vec<u8>,
}

/// The output of a network that is an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionPlace {
    /// Node.
    pub node: usize,
    /// Output of the node.
    pub output: usize,
    /// Index among the actions of all types. Actions with the same index share a standard deviation of exploration.
    pub number: usize,
}

impl Graph {
    /// Creates the graph of a building from the number of features of each node, the node and output of each action,
    /// and the number of outputs of each node type.
    pub fn new(
        plan: &NodePlan,
        widths: &[usize],
        actions: &[(usize, usize)],
        outputs: impl Fn(NodeType) -> usize,
    ) -> Self {
        let nodes = &plan.nodes;
        let mut features = vec![0];
        for width in widths {
            features.push(features[features.len() - 1] + width);
        }
        let before = |node_type: NodeType| -> usize {
            let earlier = NodeType::ALL.iter().take_while(|each| **each != node_type);
            earlier.map(|each| outputs(*each)).sum()
        };
        let place = |(node, output): &(usize, usize)| ActionPlace {
            node: *node,
            output: *output,
            number: before(nodes[*node].kind()) + output,
        };
        Self {
            names: nodes.iter().map(|node| node.name.clone()).collect(),
            types: nodes.iter().map(|node| node.node_type).collect(),
            features,
            actions: actions.iter().map(place).collect(),
            relations: relations(plan),
        }
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> usize {
        self.types.len()
    }

    /// Returns the width of a row of observations.
    pub fn width(&self) -> usize {
        self.features[self.types.len()]
    }
}

fn relations(plan: &NodePlan) -> Vec<u8> {
    let nodes = &plan.nodes;
    let mut relations = vec![0u8; nodes.len() * nodes.len()];
    let mut mark = |from: usize, to: usize, bit: u8| relations[from * nodes.len() + to] |= 1 << bit;
    for (from, to, kind) in plan.edges.iter().copied().filter(|(from, to, _)| from != to) {
        let [there, back] = match EdgeKind::ALL[kind] {
            EdgeKind::Adjacent => [0, 0],
            EdgeKind::Serves => [1, 2],
            EdgeKind::Controls => [3, 4],
        };
        mark(from, to, there);
        mark(to, from, back);
    }
    let is_part = |node: usize| nodes[node].kind().is_zone() || nodes[node].kind() == NodeType::AirLoop;
    for (pair, relation) in relations.iter_mut().enumerate() {
        let (from, to) = (pair / nodes.len(), pair % nodes.len());
        if *relation != 0 || from == to || !is_part(from) || !is_part(to) {
            *relation |= REACHES;
        }
    }
    relations
}
