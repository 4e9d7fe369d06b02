//! Buildings as graph networks see them, on the owner's side.

use std::sync::Arc;

use b2b_agent::network::Graph;
use b2b_agent::{AgentObservation, Interface, NodePlan, NodeView};
use b2b_env::Spaces;

use crate::credit::Credit;
use crate::error::Result;
use crate::rollout::Widths;

/// A building as a graph network sees it.
#[derive(Clone, Debug)]
pub(crate) struct GraphBuilding {
    /// The part that a worker needs.
    pub(super) plan: NodePlan,
    /// Its graph.
    pub(super) graph: Arc<Graph>,
    /// Credit of its actions.
    pub(super) credit: Arc<Credit>,
}

impl GraphBuilding {
    /// Returns a building that has its model; `None` for flat networks. With `by_node`, a reward has a part for every
    /// node.
    pub(crate) fn of(interface: Interface, by_node: bool, spaces: &Arc<Spaces>) -> Result<Option<Self>> {
        let Some(form) = interface.nodes else { return Ok(None) };
        let plan = NodePlan::of(form, spaces)?;
        let NodeView { graph, owners, .. } = AgentObservation::by_node(interface, spaces, &plan)?;
        let credit = match by_node {
            true => Credit::by_node(spaces, &plan, &graph, &owners),
            false => {
                let (observation, action, nodes) = (graph.width(), graph.actions.len(), graph.nodes());
                Credit::joint(Widths { observation, action, parts: 1, nodes })
            }
        };
        Ok(Some(Self { plan, graph: Arc::new(graph), credit: Arc::new(credit) }))
    }

    /// Returns the widths of its observations, actions and rewards, and its number of nodes.
    pub(crate) fn widths(&self) -> Widths {
        let Self { graph, credit, .. } = self;
        let (observation, action) = (graph.width(), graph.actions.len());
        Widths { observation, action, parts: credit.parts().len(), nodes: graph.nodes() }
    }
}
