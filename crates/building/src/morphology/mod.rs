//! The morphology of a building (as in the paper): a graph over one vocabulary for all buildings.
//!
//! The [`Universe`] has the node types with the attribute, observation and action space of each. A [`Morphology`] is
//! one building: its nodes, in the order of their types and within a type in model order, its edges, and its common
//! attributes.
//!
//! | edge | from | to | attribute |
//! |---|---|---|---|
//! | [`EdgeKind::Serves`], directed | air loop | zone that it supplies | design flow, kg/s |
//! | [`EdgeKind::Adjacent`], undirected, listed once | zone | zone | shared area, m² |
//! | [`EdgeKind::Controls`], directed | node with actions | zone that they condition: itself, for a zone with equipment, and zones that follow it | number of its actions |
//!
//! Weather, calendar and energy nodes have no edges.
//!
//! Values of the nodes are in one array per type, of `[nodes of the type, slots of the type]`; a [`Layout`] has the
//! offset of each array in one buffer. Every slot of an observation has its [`Owner`], which determines its node; the
//! environment crate has the tables for `split` and `join`.

mod layout;
mod owner;
pub(crate) mod universe;

use serde::Serialize;

pub use layout::{Block, Layout};
pub use owner::Owner;
pub use universe::{Attribute, COMMON, LocalSlot, LocalSpaces, NodeType, Observed, Universe};

use crate::description::{Description, ZoneDescription};
use crate::hvac::{System, SystemLayout};
use crate::{Conditioning, PreparedBuilding};

/// One building as a graph.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Morphology {
    /// Name of the building.
    pub name: String,
    /// Attributes of the whole building, in the order of [`COMMON`].
    pub common_attributes: Vec<f64>,
    /// The nodes, in the order of their types, then in model order.
    pub nodes: Vec<Node>,
    /// The edges.
    pub edges: Vec<Edge>,
}

/// A node of the graph: a part of a building.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Node {
    /// Its type.
    pub node_type: NodeType,
    /// Name, for example of a zone.
    pub name: String,
    /// The owner of its slots.
    pub owner: Owner,
    /// Attributes, in the order of the type's attribute space.
    pub attributes: Vec<f64>,
}

/// An edge between two nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// Its kind.
    pub kind: EdgeKind,
    /// Number of a node.
    pub from: usize,
    /// Number of a node.
    pub to: usize,
    /// Its attribute: see [`EdgeKind`].
    pub attribute: f64,
}

/// Kinds of edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeKind {
    /// An air loop supplies a zone; design flow, kg/s. Directed.
    Serves,
    /// Two zones are adjacent; shared area, m². Undirected: listed once, from the lower number.
    Adjacent,
    /// The actions of a node condition a zone; number of these actions. Directed; a zone with equipment controls
    /// itself, and the zones without actions that its unit serves.
    Controls,
}

impl EdgeKind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Serves, Self::Adjacent, Self::Controls];

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Serves => "serves",
            Self::Adjacent => "adjacent",
            Self::Controls => "controls",
        }
    }

    /// Returns whether it is directed.
    pub fn is_directed(self) -> bool {
        self != Self::Adjacent
    }
}

impl Morphology {
    /// The morphology of a prepared building with its description.
    pub fn of(building: &PreparedBuilding, description: &Description) -> Self {
        let mut nodes: Vec<Node> = [
            (NodeType::Weather, Owner::Weather),
            (NodeType::Calendar, Owner::Calendar),
            (NodeType::Energy, Owner::Energy),
        ]
        .map(|(node_type, owner)| Node {
            node_type,
            name: node_type.name().to_owned(),
            owner,
            attributes: Vec::new(),
        })
        .into();
        nodes.extend(air_loops(building, description));
        let zones = building.zones.iter().zip(&description.zones).enumerate();
        nodes.extend(zones.map(|(index, (zone, described))| {
            let node_type = zone_type(building, index);
            Node {
                node_type,
                name: zone.name.clone(),
                owner: Owner::Zone(index),
                attributes: values(node_type.attributes(), |attribute| zone_attribute(described, attribute)),
            }
        }));
        nodes.sort_by_key(|node| node.node_type);
        let edges = edges(building, description, &nodes);
        Self {
            name: building.name.clone(),
            common_attributes: values(COMMON, |attribute| match attribute {
                Attribute::Actuators => building.actuators().count() as f64,
                _ => common_attribute(description, attribute),
            }),
            nodes,
            edges,
        }
    }

    /// Returns the common attributes scaled from their bounds to [-1, 1] and clipped; unknown ones, and
    /// windows where there are none, are 0.
    pub fn scaled_common_attributes(&self) -> Vec<f64> {
        let scaled = |(slot, value): (&LocalSlot<Attribute>, &f64)| match slot.quantity {
            // 0 means that it is unknown, or that there are no windows.
            Attribute::Year
            | Attribute::WallU
            | Attribute::RoofU
            | Attribute::WindowU
            | Attribute::WindowShgc
                if *value == 0.0 =>
            {
                0.0
            }
            _ => slot.scaled(*value),
        };
        COMMON.iter().zip(&self.common_attributes).map(scaled).collect()
    }

    /// Returns the number of the node of an owner.
    pub fn node_of(&self, owner: Owner) -> Option<usize> {
        self.nodes.iter().position(|node| node.owner == owner)
    }

    /// Returns the number of nodes of a type.
    pub fn count(&self, node_type: NodeType) -> usize {
        self.nodes.iter().filter(|node| node.node_type == node_type).count()
    }

    /// Returns a node's index among the nodes of its type, which is its row in the arrays.
    pub fn row(&self, node: usize) -> usize {
        let node_type = self.nodes[node].node_type;
        self.nodes[..node].iter().filter(|other| other.node_type == node_type).count()
    }

    /// Returns the layout of the observations of the nodes.
    pub fn observation_layout(&self) -> Layout {
        Layout::new(|node_type| [self.count(node_type), node_type.observation().len()])
    }

    /// Returns the layout of the actions of the nodes.
    pub fn action_layout(&self) -> Layout {
        Layout::new(|node_type| [self.count(node_type), node_type.action().len()])
    }
}

fn air_loops<'a>(
    building: &'a PreparedBuilding,
    description: &'a Description,
) -> impl Iterator<Item = Node> + 'a {
    let systems = building.systems.iter().zip(&description.systems).enumerate();
    systems.filter_map(|(index, (system, described))| {
        if !system.has_air_handler() {
            return None;
        }
        let attribute = |attribute| match attribute {
            Attribute::DesignFlow => described.design_flow,
            Attribute::HeatingCapacity => described.heating_capacity,
            Attribute::CoolingCapacity => described.cooling_capacity,
            _ => described.zones.len() as f64,
        };
        Some(Node {
            node_type: NodeType::AirLoop,
            name: system.name().to_owned(),
            owner: Owner::AirLoop(index),
            attributes: values(NodeType::AirLoop.attributes(), attribute),
        })
    })
}

fn zone_type(building: &PreparedBuilding, zone: usize) -> NodeType {
    let of_system = |(system, layout): (&dyn System, &SystemLayout)| {
        let served = layout.zones.iter().position(|served| served.index == zone)?;
        Some(system.node_type(served))
    };
    building.laid_out_systems().find_map(of_system).unwrap_or(NodeType::UncontrolledZone)
}

fn values(space: &[LocalSlot<Attribute>], value: impl Fn(Attribute) -> f64) -> Vec<f64> {
    space.iter().map(|slot| value(slot.quantity)).collect()
}

fn zone_attribute(zone: &ZoneDescription, attribute: Attribute) -> f64 {
    let equipment = zone.equipment.unwrap_or_default();
    match attribute {
        Attribute::FloorArea => zone.floor_area,
        Attribute::Volume => zone.volume,
        Attribute::CenterX => zone.center[0],
        Attribute::CenterY => zone.center[1],
        Attribute::CenterZ => zone.center[2],
        Attribute::ExtentX => zone.extent[0],
        Attribute::ExtentY => zone.extent[1],
        Attribute::ExtentZ => zone.extent[2],
        Attribute::ExteriorWallFraction => zone.exterior_wall_fraction,
        Attribute::RoofToFloor if zone.floor_area > 0.0 => zone.roof_area / zone.floor_area,
        Attribute::GroundContactFraction => zone.ground_contact_fraction,
        Attribute::WindowToWall => zone.window_to_wall,
        Attribute::Infiltration => zone.infiltration,
        Attribute::DesignFlow => equipment.design_flow,
        Attribute::HeatingCapacity => equipment.heating_capacity,
        Attribute::CoolingCapacity => equipment.cooling_capacity,
        _ => 0.0,
    }
}

fn common_attribute(building: &Description, attribute: Attribute) -> f64 {
    let Description { location, envelope, .. } = building;
    match attribute {
        Attribute::FloorArea => building.conditioned_floor_area,
        Attribute::Volume => building.conditioned_volume,
        Attribute::Year => building.origin.year.map_or(0.0, f64::from),
        Attribute::Latitude => location.latitude,
        Attribute::HeatingDegreeDays => location.heating_degree_days,
        Attribute::CoolingDegreeDays => location.cooling_degree_days,
        Attribute::NorthAxis => building.north_axis,
        Attribute::Levels => building.levels as f64,
        Attribute::WallU => envelope.wall_u.unwrap_or(0.0),
        Attribute::RoofU => envelope.roof_u.unwrap_or(0.0),
        Attribute::WindowU => envelope.window_u.unwrap_or(0.0),
        Attribute::WindowShgc => envelope.window_shgc.unwrap_or(0.0),
        Attribute::WindowToWall => envelope.window_to_wall,
        Attribute::Infiltration => envelope.infiltration,
        Attribute::Systems => building.systems.len() as f64,
        Attribute::ControlledZones => {
            let controlled = building.zones.iter().filter(|zone| zone.conditioning != Conditioning::None);
            controlled.count() as f64
        }
        _ => 0.0,
    }
}

fn edges(building: &PreparedBuilding, description: &Description, nodes: &[Node]) -> Vec<Edge> {
    let node = |owner: Owner| nodes.iter().position(|node| node.owner == owner);
    let mut edges = Vec::new();
    for (index, system) in description.systems.iter().enumerate() {
        let Some(from) = node(Owner::AirLoop(index)) else { continue };
        for zone in &system.zones {
            let flow = description.zones[*zone].equipment.map_or(0.0, |equipment| equipment.design_flow);
            if let Some(to) = node(Owner::Zone(*zone)) {
                edges.push(Edge { kind: EdgeKind::Serves, from, to, attribute: flow });
            }
        }
    }
    for adjacency in &description.adjacency {
        if let [Some(a), Some(b)] = adjacency.zones.map(|zone| node(Owner::Zone(zone))) {
            let (from, to) = (a.min(b), a.max(b));
            edges.push(Edge { kind: EdgeKind::Adjacent, from, to, attribute: adjacency.area });
        }
    }
    let owners: Vec<Owner> = building.owned_actuators().map(|(owner, _)| owner).collect();
    let controls = |from: usize, to: usize| {
        let actions = owners.iter().filter(|owner| **owner == nodes[from].owner).count();
        Edge { kind: EdgeKind::Controls, from, to, attribute: actions as f64 }
    };
    let served: Vec<_> = edges.iter().filter(|edge| edge.kind == EdgeKind::Serves).copied().collect();
    let with_actions = (0..nodes.len()).filter(|node| owners.contains(&nodes[*node].owner));
    for from in with_actions {
        match nodes[from].owner {
            Owner::AirLoop(_) => {
                edges.extend(
                    served.iter().filter(|edge| edge.from == from).map(|edge| controls(from, edge.to)),
                );
            }
            Owner::Zone(zone) => {
                edges.push(controls(from, from));
                let of_unit = description.systems.iter().enumerate().filter(|(index, system)| {
                    node(Owner::AirLoop(*index)).is_none() && system.zones.contains(&zone)
                });
                let zones =
                    of_unit.flat_map(|(_, system)| system.zones.iter().map(|other| Owner::Zone(*other)));
                let following = zones.filter(|owner| !owners.contains(owner)).filter_map(node);
                edges.extend(following.map(|to| controls(from, to)));
            }
            _ => edges.push(controls(from, from)),
        }
    }
    edges
}
