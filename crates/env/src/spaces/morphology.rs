//! Translations between the flat vectors of an environment and the per-node arrays of a morphology.

use b2b_building::Morphology;
use b2b_building::morphology::{Layout, Node, NodeType, Observed, Owner};

use crate::spaces::action::ActionSpace;
use crate::spaces::observation::ObservationSpace;
use crate::{Error, Result};

/// The paper's two translations: `split` an observation into node observations, and `join` node actions to an action.
///
/// The tables are built once; a translation copies values between buffers of the caller and does not allocate. Each
/// slot of the observation and of the action has one cell in the node arrays, except for quantities that no node type
/// has.
///
/// Every controlled zone has cells for target and occupancy. With constant targets, the observation has no such slots,
/// and `split` writes the constant target and an occupancy of 1. With comfort bands, the target is the middle of the
/// band, or the heating setpoint of a zone without cooling; setpoints and preview have no cells.
///
/// ```text
/// decomposition.split(observation, &mut nodes);            // nodes[block.range()]: [nodes of a type, its slots]
/// policy(&nodes, &mut actions);
/// decomposition.join(&actions, &mut action);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    observation: Layout,
    action: Layout,
    /// Slots of the observation that have a cell, in order, with it.
    observed: Vec<(usize, usize)>,
    /// Cells of targets in the middle of a band, with the slots of its setpoints.
    middles: Vec<(usize, [usize; 2])>,
    /// Length of the observation.
    width: usize,
    /// Cells without a slot in the observation, with their values.
    constant: Vec<(usize, f64)>,
    /// Cell of each slot of the action.
    acted: Vec<usize>,
    /// Number of nodes of each type.
    nodes: [usize; NodeType::ALL.len()],
}

impl Decomposition {
    /// Creates the translations between the spaces of an environment and the morphology of its building.
    ///
    /// # Errors
    /// [`Error::SlotWithoutNode`] for a slot without a node.
    pub fn new(
        morphology: &Morphology,
        observation_space: &ObservationSpace,
        action_space: &ActionSpace,
    ) -> Result<Self> {
        let (observation, action) = (morphology.observation_layout(), morphology.action_layout());
        let rows = Rows::of(morphology);
        let missing =
            |slot: &str| Error::SlotWithoutNode { slot: slot.into(), building: morphology.name.clone() };
        let slots = observation_space.slots();
        let in_nodes = slots.iter().enumerate().filter(|(_, slot)| is_of_nodes(slot.quantity));
        let observed: Vec<(usize, usize)> = in_nodes
            .map(|(number, slot)| {
                let (node_type, row) = rows.find(slot.owner).ok_or_else(|| missing(&slot.name))?;
                let column = column_of(node_type, slot.quantity).ok_or_else(|| missing(&slot.name))?;
                Ok((number, observation.block(node_type).cell(row, column)))
            })
            .collect::<Result<_>>()?;
        let actuators = action_space.names().iter().zip(action_space.owners()).zip(action_space.quantities());
        let acted = actuators
            .map(|((name, owner), quantity)| {
                let (node_type, row) = rows.find(*owner).ok_or_else(|| missing(name))?;
                let column = node_type.action().iter().position(|local| local.quantity == *quantity);
                Ok(action.block(node_type).cell(row, column.ok_or_else(|| missing(name))?))
            })
            .collect::<Result<_>>()?;
        let middles = middles(morphology, &observation, observation_space);
        let mut constant = constants(morphology, &observation, observation_space, &observed);
        constant.retain(|(cell, _)| middles.iter().all(|(middle, _)| middle != cell));
        let nodes = NodeType::ALL.map(|node_type| observation.block(node_type).nodes);
        let width = observation_space.len();
        Ok(Self { observation, action, observed, middles, width, constant, acted, nodes })
    }

    /// Returns the same translations for larger arrays, so that arrays of several buildings can be stacked: for layouts
    /// that [cover](Layout::covering) all of theirs. Rows beyond [`Decomposition::nodes`] are padding:
    /// [`Decomposition::split`] leaves them unchanged, [`Decomposition::join`] does not read them.
    ///
    /// # Panics
    /// If a layout does not cover this building's.
    #[must_use]
    pub fn padded(&self, observation: &Layout, action: &Layout) -> Self {
        let moved = |to: &Layout, from: &Layout, cell: &usize| {
            to.cell_of(from, *cell).expect("the layout covers the building's")
        };
        let observed = |cell: &usize| moved(observation, &self.observation, cell);
        Self {
            observed: self.observed.iter().map(|(slot, cell)| (*slot, observed(cell))).collect(),
            middles: self.middles.iter().map(|(cell, band)| (observed(cell), *band)).collect(),
            width: self.width,
            constant: self.constant.iter().map(|(cell, value)| (observed(cell), *value)).collect(),
            acted: self.acted.iter().map(|cell| moved(action, &self.action, cell)).collect(),
            observation: observation.clone(),
            action: action.clone(),
            nodes: self.nodes,
        }
    }

    /// Number of nodes of a type in the building: the first rows of the type's array.
    pub fn nodes(&self, node_type: NodeType) -> usize {
        self.nodes[node_type as usize]
    }

    /// Layout of the node observations in their buffer.
    pub fn observation_layout(&self) -> &Layout {
        &self.observation
    }

    /// Layout of the node actions in their buffer.
    pub fn action_layout(&self) -> &Layout {
        &self.action
    }

    /// Length of the observation.
    pub fn observation_width(&self) -> usize {
        self.width
    }

    /// Cell of each slot of the observation that has one, in order.
    pub fn observation_cells(&self) -> impl Iterator<Item = usize> {
        self.observed.iter().map(|(_, cell)| *cell)
    }

    /// Cell of each slot of the action, in order.
    pub fn action_cells(&self) -> &[usize] {
        &self.acted
    }

    /// Splits an observation into node observations.
    ///
    /// # Panics
    /// If a buffer does not have the length of the observation or of its layout.
    pub fn split(&self, observation: &[f64], nodes: &mut [f64]) {
        assert_eq!(nodes.len(), self.observation.len(), "length of the node observations");
        assert_eq!(observation.len(), self.width, "length of the observation");
        for (slot, cell) in &self.observed {
            nodes[*cell] = observation[*slot];
        }
        for (cell, value) in &self.constant {
            nodes[*cell] = *value;
        }
        for (cell, [heating, cooling]) in &self.middles {
            nodes[*cell] = 0.5 * (observation[*heating] + observation[*cooling]);
        }
    }

    /// Joins node actions to an action. Cells without an actuator in the building are skipped.
    ///
    /// # Panics
    /// If a buffer does not have the length of the action or of its layout.
    pub fn join(&self, nodes: &[f64], action: &mut [f64]) {
        assert_eq!(nodes.len(), self.action.len(), "length of the node actions");
        gather(nodes, &self.acted, action);
    }

    /// Joins node observations to an observation: the inverse of [`Decomposition::split`]. Slots without a cell are
    /// left unchanged.
    ///
    /// # Panics
    /// See [`Decomposition::split`].
    pub fn join_observation(&self, nodes: &[f64], observation: &mut [f64]) {
        assert_eq!(nodes.len(), self.observation.len(), "length of the node observations");
        assert_eq!(observation.len(), self.width, "length of the observation");
        for (slot, cell) in &self.observed {
            observation[*slot] = nodes[*cell];
        }
    }

    /// Splits an action, or its bounds, into node actions: the inverse of [`Decomposition::join`]. Cells without an
    /// actuator in the building are left unchanged.
    ///
    /// # Panics
    /// See [`Decomposition::join`].
    pub fn split_action(&self, action: &[f64], nodes: &mut [f64]) {
        assert_eq!(nodes.len(), self.action.len(), "length of the node actions");
        scatter(action, &self.acted, nodes);
    }
}

/// Copies the value of each slot to its cell.
fn scatter(slots: &[f64], cells: &[usize], nodes: &mut [f64]) {
    assert_eq!(slots.len(), cells.len(), "length of the vector");
    for (cell, value) in cells.iter().zip(slots) {
        nodes[*cell] = *value;
    }
}

/// Copies the value of each slot from its cell.
fn gather(nodes: &[f64], cells: &[usize], slots: &mut [f64]) {
    assert_eq!(slots.len(), cells.len(), "length of the vector");
    for (cell, value) in cells.iter().zip(slots) {
        *value = nodes[*cell];
    }
}

/// Type and row of the node of each owner.
struct Rows(Vec<(Owner, NodeType, usize)>);

impl Rows {
    fn of(morphology: &Morphology) -> Self {
        let nodes = morphology.nodes.iter().enumerate();
        Self(nodes.map(|(number, node)| (node.owner, node.node_type, morphology.row(number))).collect())
    }

    fn find(&self, owner: Owner) -> Option<(NodeType, usize)> {
        self.0.iter().find(|(known, ..)| *known == owner).map(|(_, node_type, row)| (*node_type, *row))
    }
}

/// Returns whether a node type has the quantity.
fn is_of_nodes(quantity: Observed) -> bool {
    NodeType::ALL.into_iter().any(|node_type| column_of(node_type, quantity).is_some())
}

/// Returns the column of a quantity in the array of a node type.
fn column_of(node_type: NodeType, quantity: Observed) -> Option<usize> {
    node_type.observation().iter().position(|local| local.quantity == quantity)
}

/// Returns the cells of the targets of zones with a band, with the slots of its setpoints.
fn middles(morphology: &Morphology, layout: &Layout, space: &ObservationSpace) -> Vec<(usize, [usize; 2])> {
    let middle = |(number, node): (usize, &Node)| {
        let column = column_of(node.node_type, Observed::TargetTemperature)?;
        let slot = |quantity| {
            space.slots().iter().position(|slot| (slot.owner, slot.quantity) == (node.owner, quantity))
        };
        let heating = slot(Observed::HeatingSetpoint)?;
        let cooling = slot(Observed::CoolingSetpoint).unwrap_or(heating);
        Some((layout.block(node.node_type).cell(morphology.row(number), column), [heating, cooling]))
    };
    morphology.nodes.iter().enumerate().filter_map(middle).collect()
}

/// Returns the cells without a slot in the observation, with their values.
fn constants(
    morphology: &Morphology,
    layout: &Layout,
    space: &ObservationSpace,
    observed: &[(usize, usize)],
) -> Vec<(usize, f64)> {
    let mut constants = Vec::new();
    for (number, node) in morphology.nodes.iter().enumerate() {
        for (column, slot) in node.node_type.observation().iter().enumerate() {
            let value = match slot.quantity {
                Observed::TargetTemperature => space.constant_target().unwrap_or(0.0),
                Observed::Occupancy => 1.0,
                _ => 0.0,
            };
            let cell = layout.block(node.node_type).cell(morphology.row(number), column);
            if observed.iter().all(|(_, known)| *known != cell) {
                constants.push((cell, value));
            }
        }
    }
    constants
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spaces::slots::Slot;

    /// Two zones with unitary systems.
    fn morphology() -> Morphology {
        let zone = |number: usize| Node {
            node_type: NodeType::UnitaryZone,
            name: format!("Zone {number}"),
            owner: Owner::Zone(number),
            attributes: vec![0.0; NodeType::UnitaryZone.attributes().len()],
        };
        let nodes = vec![zone(0), zone(1)];
        Morphology { name: "Two zones".into(), common_attributes: vec![], nodes, edges: vec![] }
    }

    fn slot(zone: usize, quantity: Observed) -> Slot {
        let name = format!("Zone {zone} {quantity:?}");
        Slot { name, owner: Owner::Zone(zone), quantity, unit: "1", low: 0.0, high: 1.0, source: "test" }
    }

    fn decomposition(slots: Vec<Slot>) -> Result<Decomposition> {
        Decomposition::new(&morphology(), &ObservationSpace::of_slots(slots), &ActionSpace::empty())
    }

    #[test]
    fn an_observed_target_is_copied_and_a_missing_one_is_constant() {
        let slots = vec![
            slot(1, Observed::TargetTemperature),
            slot(0, Observed::AirTemperature),
            slot(1, Observed::Occupancy),
            slot(1, Observed::AirTemperature),
        ];
        let decomposition = decomposition(slots).unwrap();
        let mut nodes = [f64::NAN; 6];
        decomposition.split(&[18.0, 20.0, 0.0, 19.0], &mut nodes);
        assert_eq!(nodes, [20.0, 21.0, 1.0, 19.0, 18.0, 0.0]);
    }

    #[test]
    fn a_slot_without_a_cell_is_reported_by_name() {
        for slot in [slot(2, Observed::AirTemperature), slot(0, Observed::Gas)] {
            let name = slot.name.clone();
            let error = decomposition(vec![slot]).unwrap_err().to_string();
            assert!(error.contains(&name) && error.contains("Two zones"), "{error}");
        }
    }
}
