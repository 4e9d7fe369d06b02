//! Observations of graph networks: the features of each node of a building.

use std::sync::Arc;

use b2b_building::hvac::Quantity;
use b2b_building::morphology::{Attribute, COMMON, LocalSlot, NodeType, Observed, Owner};
use b2b_env::{Spaces, Target};
use serde::Serialize;

use super::agent_observation::AgentObservation;
use super::appended::OF_STEP;
use super::feature::{Feature, Source};
use super::features::{ControlledZone, calendar, energy, hours_and_seasons, temperature, weather};
use super::options::ObservationForm;
use super::supervised::{SupervisedNode, equipment, node_features, node_preview, node_shifts, set_shifts};
use crate::interface::Interface;
use crate::network::Graph;
use crate::network::graph::NodeWidths;
use crate::plan::{NodePlan, PlannedNode};
use crate::supervisor::Supervisor;
use crate::{Error, Result};

/// The observation of a building node by node, and its graph.
#[derive(Clone, Debug)]
pub struct NodeView {
    /// The features of all nodes, one node after another.
    pub observation: AgentObservation,
    /// The assignment of features and actions to nodes.
    pub graph: Graph,
    /// Index of the actuator or supervisory point of each action.
    pub actuators: Vec<usize>,
    /// Owner of the actuator or supervisory point of each action.
    pub owners: Vec<Owner>,
}

/// The features and actions of each node type, which are the same in every building.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeSpaces {
    types: Vec<TypeSpaces>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct TypeSpaces {
    name: &'static str,
    features: Vec<String>,
    actions: Vec<String>,
}

impl NodeSpaces {
    /// Returns the spaces of all node types for an agent with a graph network.
    pub fn of(interface: Interface) -> Self {
        let types = NodeType::ALL.map(|node_type| TypeSpaces {
            name: node_type.name(),
            features: local_features(interface, node_type, &Nowhere, None)
                .into_iter()
                .map(|(name, _)| name)
                .collect(),
            actions: action_names(interface, node_type),
        });
        Self { types: types.into() }
    }

    /// Returns the spaces of the first `count` types, for an agent saved before the others were added.
    #[must_use]
    pub fn first(mut self, count: usize) -> Self {
        self.types.truncate(count);
        self
    }

    /// Returns the name of every feature of every type.
    pub fn slots(&self) -> Vec<String> {
        self.names(|each| &each.features)
    }

    /// Returns the name of every action of every type.
    pub fn actuators(&self) -> Vec<String> {
        self.names(|each| &each.actions)
    }

    /// Returns the numbers of features and actions of a node of each type.
    pub fn widths(&self) -> Vec<NodeWidths> {
        let widths =
            |each: &TypeSpaces| NodeWidths { features: each.features.len(), outputs: each.actions.len() };
        self.types.iter().map(widths).collect()
    }

    fn names(&self, of: fn(&TypeSpaces) -> &Vec<String>) -> Vec<String> {
        let mut names = Vec::new();
        for each in &self.types {
            names.extend(of(each).iter().map(|name| format!("{}: {name}", each.name)));
        }
        names
    }
}

impl AgentObservation {
    /// Returns the observation of a building node by node: with `raw` or `roles`, the observation of each node, scaled
    /// to [-1, 1] by bounds that all buildings share; with `features`, the features of its own zone or actuators.
    ///
    /// # Errors
    /// [`Error::Graph`] for a building with an actuator that belongs to no node, or that its node's type does not have.
    pub fn by_node(interface: Interface, spaces: &Arc<Spaces>, plan: &NodePlan) -> Result<NodeView> {
        let failed = |what: &str, name: &str| Error::Graph {
            building: spaces.building.name.clone(),
            source: format!("{what} {name}").into(),
        };
        let supervisor =
            interface.acting.is_supervision().then(|| Supervisor::new(interface.acting, true, spaces));
        let (mut features, mut widths) = (Vec::new(), Vec::new());
        for node in &plan.nodes {
            let supervised =
                supervisor.as_ref().map(|supervisor| SupervisedNode::new(spaces, supervisor, node.owner()));
            let placed = Placed { spaces, plan, node };
            let local = local_features(interface, node.kind(), &placed, supervised.as_ref());
            widths.push(local.len());
            let name = |what: String| match what.starts_with(&node.name) {
                true => what,
                false => format!("{} {what}", node.name),
            };
            features.extend(local.into_iter().map(|(what, source)| Feature::new(name(what), source)));
        }
        let (mut actions, mut actuators, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for (actuator, (owner, what)) in acted(spaces, supervisor.as_ref()).into_iter().enumerate() {
            let has_it = |node: &PlannedNode| node.owner() == owner;
            let Some(node) = plan.nodes.iter().position(has_it) else {
                match plan.left_out.iter().any(has_it) {
                    true => continue,
                    false => return Err(failed("no node has", &what)),
                }
            };
            let names = action_names(interface, plan.nodes[node].kind());
            let output = names.iter().position(|name| *name == what);
            actions.push((node, output.ok_or_else(|| failed("its node does not have", &what))?));
            actuators.push(actuator);
            owners.push(owner);
        }
        let outputs = |node_type| action_names(interface, node_type).len();
        let graph = Graph::new(plan, &widths, &actions, outputs);
        let observation = Self::of_features(features, spaces, supervisor.is_some());
        Ok(NodeView { observation, graph, actuators, owners })
    }
}

/// Returns the owner of every actuator, or of every supervisory point, and its name within a node.
fn acted(spaces: &Spaces, supervisor: Option<&Supervisor>) -> Vec<(Owner, String)> {
    match supervisor {
        Some(supervisor) => {
            supervisor.points().map(|point| (point.owner, point.shift.described().0.to_owned())).collect()
        }
        None => {
            let action = &spaces.action;
            let actuators = action.owners().iter().zip(action.quantities());
            actuators.map(|(owner, quantity)| (*owner, text(quantity))).collect()
        }
    }
}

/// Returns the names of the actions of a node of a type.
fn action_names(interface: Interface, node_type: NodeType) -> Vec<String> {
    match interface.acting.is_supervision() {
        true => set_shifts(interface.acting, node_type).map(|shift| shift.described().0.to_owned()).collect(),
        false => node_type.action().iter().map(|slot| text(&slot.quantity)).collect(),
    }
}

/// Slots and actuators of a node.
trait Places {
    /// Slot of a quantity in the environment's observation.
    fn slot(&self, quantity: Observed) -> Option<usize>;

    /// Index of an actuator.
    fn actuator(&self, quantity: Quantity) -> Option<usize>;

    /// Slots of a controlled zone.
    fn controlled_zone(&self) -> ControlledZone;

    /// Scaled attributes of the node, and of the building.
    fn attributes(&self) -> [Vec<f64>; 2];

    fn steps_per_hour(&self) -> u32;
}

/// A node of a building.
struct Placed<'a> {
    spaces: &'a Spaces,
    plan: &'a NodePlan,
    node: &'a PlannedNode,
}

/// A node without a building, to list the names of features.
struct Nowhere;

impl Places for Placed<'_> {
    fn slot(&self, quantity: Observed) -> Option<usize> {
        let slots = self.spaces.observation.slots();
        slots.iter().position(|slot| slot.owner == self.node.owner() && slot.quantity == quantity)
    }

    fn actuator(&self, quantity: Quantity) -> Option<usize> {
        let action = &self.spaces.action;
        let mut actuators = action.owners().iter().zip(action.quantities());
        actuators.position(|(owner, each)| *owner == self.node.owner() && *each == quantity)
    }

    fn controlled_zone(&self) -> ControlledZone {
        let space = &self.spaces.observation;
        let is_own = |zone: usize| self.node.owner() == Owner::Zone(zone);
        let own = self.spaces.controlled_zones().enumerate().find(|(_, zone)| is_own(*zone));
        let (zone, temperature) = own.expect("a zone with equipment is controlled");
        ControlledZone { zone, temperature, target: space.target(zone), occupancy: space.occupancy(zone) }
    }

    fn attributes(&self) -> [Vec<f64>; 2] {
        [self.node.attributes.clone(), self.plan.common_attributes.clone()]
    }

    fn steps_per_hour(&self) -> u32 {
        self.spaces.episode.steps_per_hour
    }
}

impl Places for Nowhere {
    fn slot(&self, _: Observed) -> Option<usize> {
        Some(0)
    }

    fn actuator(&self, _: Quantity) -> Option<usize> {
        Some(0)
    }

    fn controlled_zone(&self) -> ControlledZone {
        ControlledZone { zone: 0, temperature: 0, target: Target::Always(0.0), occupancy: None }
    }

    fn attributes(&self) -> [Vec<f64>; 2] {
        [
            vec![0.0; NodeType::ALL.map(|each| each.attributes().len()).into_iter().max().unwrap_or(0)],
            vec![0.0; COMMON.len()],
        ]
    }

    fn steps_per_hour(&self) -> u32 {
        1
    }
}

/// Returns the features of a node, in an order that depends only on its type.
fn local_features(
    interface: Interface,
    node_type: NodeType,
    places: &dyn Places,
    supervised: Option<&SupervisedNode<'_>>,
) -> Vec<(String, Source)> {
    let is_supervision = interface.acting.is_supervision();
    let mut features = match interface.observation.form {
        ObservationForm::Raw | ObservationForm::Roles => observed(node_type, places),
        ObservationForm::Features if is_supervision && !node_shifts(node_type).is_empty() => {
            node_features(interface.acting, node_type, supervised)
        }
        ObservationForm::Features => computed(interface, node_type, places),
    };
    if is_supervision && interface.observation.form == ObservationForm::Features {
        features.extend(node_preview(node_type, supervised));
    }
    if interface.nodes.is_some_and(|form| form.attributes) {
        let [own, common] = places.attributes();
        features.extend(constants(node_type.attributes(), &own));
        if is_supervision {
            features.extend(equipment(node_type, supervised));
        }
        if node_type == NodeType::Weather {
            features.extend(constants(COMMON, &common));
        }
    }
    if interface.observation.feedback && node_type == NodeType::Energy {
        features.extend(OF_STEP.map(|(name, source)| (name.to_owned(), source)));
    }
    features
}

fn constants(slots: &[LocalSlot<Attribute>], values: &[f64]) -> impl Iterator<Item = (String, Source)> {
    slots.iter().zip(values).map(|(slot, value)| (text(&slot.quantity), Source::Constant(*value)))
}

/// Returns the observation of a node, scaled to [-1, 1] by bounds that all buildings share. A zone with a constant
/// target observes that target and counts as occupied.
fn observed(node_type: NodeType, places: &dyn Places) -> Vec<(String, Source)> {
    let source = |slot: &LocalSlot<Observed>| {
        let LocalSlot { quantity, low, high, .. } = *slot;
        if let Some(slot) = places.slot(quantity) {
            return Source::Bounded { slot, low, high };
        }
        let value = match (quantity, places.controlled_zone().target) {
            (Observed::TargetTemperature, Target::Always(target)) => target,
            (Observed::Occupancy, _) => 1.0,
            _ => low,
        };
        Source::Constant(slot.scaled(value))
    };
    node_type.observation().iter().map(|slot| (text(&slot.quantity), source(slot))).collect()
}

/// Returns the features of a node for [`ObservationForm::Features`].
fn computed(interface: Interface, node_type: NodeType, places: &dyn Places) -> Vec<(String, Source)> {
    let slot = |quantity| places.slot(quantity).unwrap_or_default();
    let owned = |features: &[(&str, Source)]| -> Vec<(String, Source)> {
        features.iter().map(|(name, source)| ((*name).to_owned(), *source)).collect()
    };
    let mut features = match node_type {
        NodeType::Weather => {
            owned(&weather(slot(Observed::OutdoorTemperature), slot(Observed::OutdoorHumidity)))
        }
        NodeType::Calendar => {
            // A supervisor observes the bands, which already tell when people arrive.
            let times = if interface.acting.is_supervision() { hours_and_seasons } else { calendar };
            times(slot(Observed::TimeOfDay), slot(Observed::DayOfWeek), slot(Observed::DayOfYear))
        }
        NodeType::Energy => {
            owned(&energy(slot(Observed::Electricity), slot(Observed::Gas), places.steps_per_hour()))
        }
        NodeType::AirLoop => Vec::new(),
        NodeType::UncontrolledZone => owned(&[("temperature", temperature(slot(Observed::AirTemperature)))]),
        _ => owned(&places.controlled_zone().features()),
    };
    for action in node_type.action() {
        let actuator = places.actuator(action.quantity);
        let of = |source: fn(usize) -> Source| actuator.map_or(Source::Constant(0.0), source);
        let name = text(&action.quantity);
        features.push((format!("{name} previous"), of(Source::Previous)));
        if interface.acting.is_correction() {
            features.push((format!("{name} base"), of(Source::Base)));
        }
    }
    features
}

/// Returns the name of a quantity, such as `air temperature`.
fn text(quantity: &impl Serialize) -> String {
    let name = serde_json::to_value(quantity).expect("a quantity is a name");
    name.as_str().unwrap_or_default().replace('_', " ")
}
