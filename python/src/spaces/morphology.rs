//! A building as a graph, and the maps between its vectors and the arrays of its nodes.

use b2b_building::morphology::{
    self as graph, Attribute, Block, COMMON, EdgeKind, Layout, LocalSlot, Morphology as Graph, Universe,
};
use b2b_env::Decomposition;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use serde::Serialize;

use crate::env::owner::{Owner, name_of};
use crate::interpreter::arrays;
use crate::interpreter::error::Exception;

/// A building as a graph, with the maps between its vectors and the arrays of its nodes.
///
/// The arrays of all node types, `[nodes, slots]` each, are stored one after another in a single buffer.
#[pyclass(frozen, module = "building2building._core")]
pub struct Morphology {
    graph: Graph,
    decomposition: Decomposition,
}

/// A node of the graph.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct Node {
    /// Name of its type.
    node_type: String,
    /// Name, for example of a zone.
    name: String,
    /// The part of the building that it represents.
    owner: Py<Owner>,
    /// Row in the arrays of its type.
    row: usize,
    /// Attributes, in the order of its type; 0 where unknown.
    attributes: Vec<f64>,
}

/// An edge of the graph.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct Edge {
    /// `serves`, `adjacent` or `controls`.
    kind: String,
    /// Whether its direction matters; if not, it is listed once.
    directed: bool,
    /// Index of the node that it leaves.
    source: usize,
    /// Index of the node that it enters.
    target: usize,
    /// Design flow (kg/s) of `serves`, shared area (m²) of `adjacent`, number of actions of `controls`.
    attribute: f64,
}

/// A quantity of a node type.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct NodeSlot {
    /// Name, for example `air_temperature`.
    quantity: String,
    /// SI unit.
    unit: &'static str,
    /// Lower bound.
    low: f64,
    /// Upper bound.
    high: f64,
}

/// A node type with its spaces, which are the same for every building.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct NodeType {
    /// Name, for example `unitary_zone`.
    name: String,
    /// Constant attributes.
    attributes: Vec<Py<NodeSlot>>,
    /// Observed quantities.
    observation: Vec<Py<NodeSlot>>,
    /// Actuated quantities.
    action: Vec<Py<NodeSlot>>,
    /// Block of its observations in the buffer: offset, nodes, slots.
    observation_block: (usize, usize, usize),
    /// Block of its actions in the buffer: offset, nodes, slots.
    action_block: (usize, usize, usize),
}

impl Morphology {
    /// Creates the morphology of a building.
    pub fn new(graph: Graph, decomposition: Decomposition) -> Self {
        Self { graph, decomposition }
    }
}

#[pymethods]
impl Morphology {
    /// Name of the building.
    #[getter]
    fn name(&self) -> &str {
        &self.graph.name
    }

    /// Node types, in the order of the buffers.
    #[getter]
    fn node_types(&self, py: Python<'_>) -> PyResult<Vec<NodeType>> {
        let node_type = |spaces: graph::LocalSpaces| {
            let block = |layout: &Layout| {
                let Block { offset, nodes, slots } = layout.block(spaces.node_type);
                (offset, nodes, slots)
            };
            Ok(NodeType {
                name: name_of(spaces.node_type),
                attributes: slots(py, spaces.attributes)?,
                observation: slots(py, spaces.observation)?,
                action: slots(py, spaces.action)?,
                observation_block: block(self.decomposition.observation_layout()),
                action_block: block(self.decomposition.action_layout()),
            })
        };
        Universe::new().node_types.into_iter().map(node_type).collect()
    }

    /// Attributes of the whole building: name and value; 0 where unknown.
    #[getter]
    fn common_attributes(&self) -> Vec<(String, f64)> {
        let name = |slot: &LocalSlot<Attribute>| name_of(slot.quantity);
        COMMON.iter().map(name).zip(self.graph.common_attributes.iter().copied()).collect()
    }

    /// Slots of the attributes of the whole building, which are the same for every building.
    #[getter]
    fn common_attribute_slots(&self, py: Python<'_>) -> PyResult<Vec<Py<NodeSlot>>> {
        slots(py, COMMON)
    }

    /// Attributes of the whole building, scaled from their bounds to [-1, 1] and clipped; 0 where unknown.
    #[getter]
    fn scaled_common_attributes(&self) -> Vec<f64> {
        self.graph.scaled_common_attributes()
    }

    /// The nodes, ordered by type.
    #[getter]
    fn nodes(&self, py: Python<'_>) -> PyResult<Vec<Node>> {
        let node = |(index, node): (usize, &graph::Node)| {
            Ok(Node {
                node_type: name_of(node.node_type),
                name: node.name.clone(),
                owner: Py::new(py, Owner::from(node.owner))?,
                row: self.graph.row(index),
                attributes: node.attributes.clone(),
            })
        };
        self.graph.nodes.iter().enumerate().map(node).collect()
    }

    /// The edges.
    #[getter]
    fn edges(&self) -> Vec<Edge> {
        let edge = |edge: &graph::Edge| Edge {
            kind: edge.kind.name().to_owned(),
            directed: edge.kind.is_directed(),
            source: edge.from,
            target: edge.to,
            attribute: edge.attribute,
        };
        self.graph.edges.iter().map(edge).collect()
    }

    /// Names of the kinds of edges.
    #[staticmethod]
    fn edge_kinds() -> Vec<&'static str> {
        EdgeKind::ALL.map(EdgeKind::name).to_vec()
    }

    /// Splits observations, one per row, into rows of the nodes' buffer.
    fn split<'py>(
        &self,
        py: Python<'py>,
        observations: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (values, [count, width]) = arrays::rows(observations)?;
        let expected = self.decomposition.observation_width();
        check_width("observation", width, expected)?;
        let nodes = self.decomposition.observation_layout().len();
        let (mut buffer, mut all) = (vec![0.0; nodes], Vec::with_capacity(count * nodes));
        for row in values.chunks_exact(width) {
            self.decomposition.split(row, &mut buffer);
            all.extend(buffer.iter().map(|value| *value as f32));
        }
        arrays::table(py, all, [count, nodes])
    }

    /// Joins rows of the nodes' buffer of actions into actions, one per row.
    fn join<'py>(&self, py: Python<'py>, nodes: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (values, [count, width]) = arrays::rows(nodes)?;
        check_width("array of node actions", width, self.decomposition.action_layout().len())?;
        let actuators = self.decomposition.action_cells().len();
        let (mut action, mut all) = (vec![0.0; actuators], Vec::with_capacity(count * actuators));
        for row in values.chunks_exact(width) {
            self.decomposition.join(row, &mut action);
            all.extend_from_slice(&action);
        }
        arrays::table(py, all, [count, actuators])
    }

    /// Splits an action, or a vector of bounds, into the nodes' buffer of actions; slots without an actuator are 0.
    fn split_action<'py>(
        &self,
        py: Python<'py>,
        action: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let action = arrays::numbers(action)?;
        check_width("action", action.len(), self.decomposition.action_cells().len())?;
        let mut buffer = vec![0.0; self.decomposition.action_layout().len()];
        self.decomposition.split_action(&action, &mut buffer);
        Ok(arrays::row(py, &buffer))
    }
}

fn slots<Q: Copy + Serialize>(py: Python<'_>, slots: &[LocalSlot<Q>]) -> PyResult<Vec<Py<NodeSlot>>> {
    let slot = |slot: &LocalSlot<Q>| {
        let LocalSlot { quantity, unit, low, high } = *slot;
        Py::new(py, NodeSlot { quantity: name_of(quantity), unit, low, high })
    };
    slots.iter().map(slot).collect()
}

fn check_width(what: &str, given: usize, expected: usize) -> PyResult<()> {
    if given == expected {
        return Ok(());
    }
    Err(Exception::Action.new_err(format!("the {what} has {given} values; expected {expected}")))
}
