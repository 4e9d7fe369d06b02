//! A building as a graph network sees it.

use b2b_building::morphology::{EdgeKind, NodeType};

use crate::plan::NodePlan;

/// Kinds of edges as a node sees them: adjacent, serves, is served by, controls, is controlled by.
pub const RELATIONS: usize = 5;
/// The bit of a pair of nodes of which the first may attend to the second where attention is along edges alone.
pub const REACHES: u8 = 1 << 7;

/// The nodes of a building: types, features, actions and edges.
///
/// A row of observations has the features of the nodes one after another, a row of actions those of the building in the order
/// of its actuators.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Graph {
    /// Name of each node.
    pub names: Vec<String>,
    /// Type of each node, as a place among the types of the network.
    pub types: Vec<usize>,
    /// Where the features of each node begin in a row, and the width of a row at the end.
    pub features: Vec<usize>,
    /// Node and output of each action.
    pub actions: Vec<ActionPlace>,
    /// Edges from the node of each row to that of each column: a bit for each of [`RELATIONS`], and [`REACHES`].
    pub relations: Vec<u8>,
}

/// Where an action is among the outputs of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionPlace {
    /// Node.
    pub node: usize,
    /// Output of the node.
    pub output: usize,
    /// Number among the actions of all types: actions with one number share an exploration noise.
    pub number: usize,
}

impl Graph {
    /// Returns the graph of a building whose nodes have this many features, and whose actions are these outputs of nodes.
    pub fn new(plan: &NodePlan, widths: &[usize], actions: &[(usize, usize)]) -> Self {
        let nodes = &plan.nodes;
        let mut features = vec![0];
        for width in widths {
            features.push(features[features.len() - 1] + width);
        }
        let before = |node_type: NodeType| -> usize {
            let earlier = NodeType::ALL.iter().take_while(|each| **each != node_type);
            earlier.map(|each| each.action().len()).sum()
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
