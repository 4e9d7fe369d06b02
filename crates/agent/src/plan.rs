//! The parts of a building's model that graph networks need in addition to its spaces.

use b2b_building::description::Origin;
use b2b_building::morphology::{EdgeKind, NodeType, Owner};
use b2b_building::{Description, Morphology};
use b2b_env::Spaces;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// How a graph network observes a building.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodeForm {
    /// Whether nodes have their attributes as features, and the weather node the building's attributes.
    pub attributes: bool,
}

/// The nodes and edges of a building, derived from its model. A worker process drops the model and gets the plan from
/// its owner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodePlan {
    /// The nodes, in the order of the morphology.
    pub nodes: Vec<PlannedNode>,
    /// The edges: from, to, and index of the kind in [`EdgeKind::ALL`].
    pub edges: Vec<(usize, usize, usize)>,
    /// Scaled attributes of the building, if observed.
    pub common_attributes: Vec<f64>,
    /// Nodes of types unknown to the network: see [`NodePlan::restricted_to`].
    pub left_out: Vec<PlannedNode>,
}

/// A node of a [`NodePlan`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedNode {
    /// Its type, as an index into [`NodeType::ALL`].
    pub node_type: usize,
    /// Its name.
    pub name: String,
    /// Number of its zone or system; 0 for other nodes.
    pub number: usize,
    /// Scaled attributes, if observed.
    pub attributes: Vec<f64>,
}

impl NodePlan {
    /// Returns the plan of a building that still has its model.
    ///
    /// # Errors
    /// [`Error::Graph`] for a model that cannot be described.
    pub fn of(form: NodeForm, spaces: &Spaces) -> Result<Self> {
        let described = Description::of(&spaces.building, &spaces.episode.weather, Origin::default());
        let failed = |source: b2b_building::Error| Error::Graph {
            building: spaces.building.name.clone(),
            source: source.into(),
        };
        let morphology = Morphology::of(&spaces.building, &described.map_err(failed)?);
        let nodes = morphology.nodes.iter().map(|node| {
            let own = node.node_type.attributes().iter().zip(&node.attributes);
            PlannedNode {
                node_type: node.node_type as usize,
                name: node.name.clone(),
                number: match node.owner {
                    Owner::Zone(number) | Owner::AirLoop(number) => number,
                    Owner::Weather | Owner::Calendar | Owner::Energy => 0,
                },
                attributes: own
                    .filter(|_| form.attributes)
                    .map(|(slot, value)| slot.scaled(*value))
                    .collect(),
            }
        });
        let number = |kind: EdgeKind| EdgeKind::ALL.iter().position(|each| *each == kind).unwrap_or_default();
        let edges = morphology.edges.iter().map(|edge| (edge.from, edge.to, number(edge.kind)));
        let common = if form.attributes { morphology.scaled_common_attributes() } else { Vec::new() };
        Ok(Self {
            nodes: nodes.collect(),
            edges: edges.collect(),
            common_attributes: common,
            left_out: Vec::new(),
        })
    }

    /// Removes the nodes of other types, and their edges.
    #[must_use]
    pub fn restricted_to(self, types: &[String]) -> Self {
        let is_known = |node: &PlannedNode| types.iter().any(|each| each == node.kind().name());
        let kept: Vec<usize> = (0..self.nodes.len()).filter(|node| is_known(&self.nodes[*node])).collect();
        let place = |node: usize| kept.binary_search(&node).ok();
        let edges =
            self.edges.iter().filter_map(|(from, to, kind)| Some((place(*from)?, place(*to)?, *kind)));
        let edges = edges.collect();
        let (nodes, left_out) = self.nodes.into_iter().partition(is_known);
        Self { nodes, edges, left_out, ..self }
    }
}

impl PlannedNode {
    /// Returns its type.
    pub fn kind(&self) -> NodeType {
        NodeType::ALL[self.node_type]
    }

    /// Returns the owner of its slots.
    pub fn owner(&self) -> Owner {
        match self.kind() {
            NodeType::Weather => Owner::Weather,
            NodeType::Calendar => Owner::Calendar,
            NodeType::Energy => Owner::Energy,
            NodeType::AirLoop => Owner::AirLoop(self.number),
            _ => Owner::Zone(self.number),
        }
    }
}
