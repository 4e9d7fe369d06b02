//! Buildings as graph networks see them, on the owner's side.

use std::sync::Arc;

use b2b_agent::network::Graph;
use b2b_agent::{AgentObservation, Interface, NodePlan};
use b2b_env::Spaces;

use crate::error::Result;

/// A building as a graph network sees it.
#[derive(Clone, Debug)]
pub(crate) struct GraphBuilding {
    /// What a worker needs to know of it.
    pub(super) plan: NodePlan,
    /// Its graph.
    pub(super) graph: Arc<Graph>,
}

impl GraphBuilding {
    /// Returns a building that has its model; `None` for flat networks.
    pub(crate) fn of(interface: Interface, spaces: &Arc<Spaces>) -> Result<Option<Self>> {
        let Some(form) = interface.nodes else { return Ok(None) };
        let plan = NodePlan::of(form, spaces)?;
        let graph = Arc::new(AgentObservation::by_node(interface, spaces, &plan)?.graph);
        Ok(Some(Self { plan, graph }))
    }

    /// Returns the widths of its observation and of its actions.
    pub(crate) fn widths(&self) -> (usize, usize) {
        (self.graph.width(), self.graph.actions.len())
    }
}
