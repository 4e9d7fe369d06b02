//! The structured form of an environment: its vectors as arrays of the nodes of a morphology, and back.

use b2b_building::Morphology;
use b2b_building::morphology::{Layout, NodeType, Observed, Owner};

use crate::action::ActionSpace;
use crate::observation::ObservationSpace;
use crate::{Error, Result};

/// The paper's pair of translations: `split` of an observation into the observations of the nodes, and `join` of the
/// actions of the nodes into an action.
///
/// Tables are made once; a translation copies numbers between buffers of the caller and allocates nothing. Each slot of
/// the observation and of the action has one cell of its own in the arrays of the nodes.
///
/// Target and occupancy have cells on every controlled zone. Where the observation has no such slots, because targets
/// never move, `split` fills in that target, occupied.
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
    /// The cell of each slot of the observation.
    observed: Vec<usize>,
    /// Cells that no slot of the observation fills, with their values.
    constant: Vec<(usize, f64)>,
    /// The cell of each slot of the action.
    acted: Vec<usize>,
    /// Nodes of each type.
    nodes: [usize; NodeType::ALL.len()],
}

impl Decomposition {
    /// The translations between the spaces of an environment and the morphology of its building.
    ///
    /// # Errors
    /// [`Error::SlotWithoutNode`] naming the slot that the morphology has no place for.
    pub fn new(
        morphology: &Morphology,
        observation_space: &ObservationSpace,
        action_space: &ActionSpace,
    ) -> Result<Self> {
        let (observation, action) = (morphology.observation_layout(), morphology.action_layout());
        let rows = Rows::of(morphology);
        let missing =
            |slot: &str| Error::SlotWithoutNode { slot: slot.into(), building: morphology.name.clone() };
        let observed: Vec<usize> = observation_space
            .slots()
            .iter()
            .map(|slot| {
                let (node_type, row) = rows.find(slot.owner).ok_or_else(|| missing(&slot.name))?;
                let column = node_type.observation().iter().position(|local| local.quantity == slot.quantity);
                let column = column.ok_or_else(|| missing(&slot.name))?;
                Ok(observation.block(node_type).cell(row, column))
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
        let constant = constants(morphology, &observation, observation_space, &observed);
        let nodes = NodeType::ALL.map(|node_type| observation.block(node_type).nodes);
        Ok(Self { observation, action, observed, constant, acted, nodes })
    }

    /// The same translations to and from larger arrays, so that those of different buildings stack: to layouts that
    /// [cover](Layout::covering) those of each. Rows beyond [`Decomposition::nodes`] are padding: [`Decomposition::split`]
    /// leaves them as they are, [`Decomposition::join`] does not read them.
    ///
    /// # Panics
    /// When a layout does not cover that of this building.
    #[must_use]
    pub fn padded(&self, observation: &Layout, action: &Layout) -> Self {
        let moved = |to: &Layout, from: &Layout, cell: &usize| {
            to.cell_of(from, *cell).expect("the layout covers that of the building")
        };
        let observed = |cell: &usize| moved(observation, &self.observation, cell);
        Self {
            observed: self.observed.iter().map(observed).collect(),
            constant: self.constant.iter().map(|(cell, value)| (observed(cell), *value)).collect(),
            acted: self.acted.iter().map(|cell| moved(action, &self.action, cell)).collect(),
            observation: observation.clone(),
            action: action.clone(),
            nodes: self.nodes,
        }
    }

    /// How many nodes of a type the building has: the first rows of the type's array.
    pub fn nodes(&self, node_type: NodeType) -> usize {
        self.nodes[node_type as usize]
    }

    /// Where the observations of the nodes are in their buffer.
    pub fn observation_layout(&self) -> &Layout {
        &self.observation
    }

    /// Where the actions of the nodes are in their buffer.
    pub fn action_layout(&self) -> &Layout {
        &self.action
    }

    /// The cell of each slot of the observation, in its order.
    pub fn observation_cells(&self) -> &[usize] {
        &self.observed
    }

    /// The cell of each slot of the action, in its order.
    pub fn action_cells(&self) -> &[usize] {
        &self.acted
    }

    /// Splits an observation into the observations of the nodes.
    ///
    /// # Panics
    /// When a buffer is not as long as the observation, or as its layout.
    pub fn split(&self, observation: &[f64], nodes: &mut [f64]) {
        assert_eq!(nodes.len(), self.observation.len(), "length of the observations of the nodes");
        scatter(observation, &self.observed, nodes);
        for (cell, value) in &self.constant {
            nodes[*cell] = *value;
        }
    }

    /// Joins the actions of the nodes to an action. Cells that the building does not drive are passed over.
    ///
    /// # Panics
    /// When a buffer is not as long as the action, or as its layout.
    pub fn join(&self, nodes: &[f64], action: &mut [f64]) {
        assert_eq!(nodes.len(), self.action.len(), "length of the actions of the nodes");
        gather(nodes, &self.acted, action);
    }

    /// Joins the observations of the nodes to an observation: undoes [`Decomposition::split`].
    ///
    /// # Panics
    /// As [`Decomposition::split`].
    pub fn join_observation(&self, nodes: &[f64], observation: &mut [f64]) {
        assert_eq!(nodes.len(), self.observation.len(), "length of the observations of the nodes");
        gather(nodes, &self.observed, observation);
    }

    /// Splits an action, or its bounds, into the actions of the nodes: [`Decomposition::join`] undoes it. Cells that the
    /// building does not drive stay as they are.
    ///
    /// # Panics
    /// As [`Decomposition::join`].
    pub fn split_action(&self, action: &[f64], nodes: &mut [f64]) {
        assert_eq!(nodes.len(), self.action.len(), "length of the actions of the nodes");
        scatter(action, &self.acted, nodes);
    }
}

/// Puts the value of each slot into its cell.
fn scatter(slots: &[f64], cells: &[usize], nodes: &mut [f64]) {
    assert_eq!(slots.len(), cells.len(), "length of the vector");
    for (cell, value) in cells.iter().zip(slots) {
        nodes[*cell] = *value;
    }
}

/// Takes the value of each slot from its cell.
fn gather(nodes: &[f64], cells: &[usize], slots: &mut [f64]) {
    assert_eq!(slots.len(), cells.len(), "length of the vector");
    for (cell, value) in cells.iter().zip(slots) {
        *value = nodes[*cell];
    }
}

/// The type and the row of the node of each owner.
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

/// What is in cells that the observation does not have.
fn constants(
    morphology: &Morphology,
    layout: &Layout,
    space: &ObservationSpace,
    observed: &[usize],
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
            if !observed.contains(&cell) {
                constants.push((cell, value));
            }
        }
    }
    constants
}

#[cfg(test)]
mod tests {
    use b2b_building::morphology::Node;

    use super::*;
    use crate::observation::Slot;

    /// Two zones with units.
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
    fn a_target_that_is_observed_is_taken_and_one_that_is_not_is_the_constant_one() {
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
    fn a_slot_without_a_node_or_a_place_on_it_is_named() {
        for slot in [slot(2, Observed::AirTemperature), slot(0, Observed::Gas)] {
            let name = slot.name.clone();
            let error = decomposition(vec![slot]).unwrap_err().to_string();
            assert!(error.contains(&name) && error.contains("Two zones"), "{error}");
        }
    }
}
