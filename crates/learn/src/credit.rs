//! Credit: which parts of a reward count in the advantage of each action.
//!
//! Actions form groups. Each group has its own advantage, and PPO's probability ratio is the joint ratio of the group's
//! actions.
//!
//! - Ordinary PPO has one group of all actions, with the advantage of the summed parts.
//! - With a credit matrix, each action is a group. Its advantage is the sum of the parts' advantages, weighted by its
//!   row. A matrix of ones is ordinary PPO.
//!
//! A reward has a part for each controlled zone and one for energy. Flat networks have them in this order; in graph
//! networks each part belongs to its node, and all other nodes have none.

use std::ops::Range;

use b2b_agent::NodePlan;
use b2b_agent::network::Graph;
use b2b_building::morphology::Owner;
use b2b_env::Spaces;

use crate::error::{Error, Result};
use crate::widths::Widths;

/// The groups of actions of a building, and the parts of its reward that count in their advantages.
#[derive(Clone, Debug, PartialEq)]
pub struct Credit {
    /// Actions of a group.
    size: usize,
    /// Kind of each group. Advantages of one kind are normalized together.
    kinds: Vec<usize>,
    /// Kind of each part. Returns of one kind are normalized together. A part without a kind has no rewards.
    parts: Vec<Option<usize>>,
    /// Weights, groups × parts.
    weights: Vec<f32>,
    /// Part of the energy penalty.
    energy: usize,
}

impl Credit {
    /// Returns the credit of a single group of all actions.
    pub fn joint(widths: Widths) -> Self {
        let Widths { action, parts, .. } = widths;
        Self {
            size: action,
            kinds: vec![0],
            parts: (0..parts).map(Some).collect(),
            weights: vec![1.0; parts],
            energy: parts - 1,
        }
    }

    /// Returns the credit for a matrix, actions × parts; without a matrix, for a single group.
    ///
    /// # Errors
    /// When the matrix has another shape.
    pub fn new(matrix: Option<&[Vec<f32>]>, widths: Widths) -> Result<Self> {
        let Widths { action, parts, .. } = widths;
        let joint = Self::joint(widths);
        let Some(matrix) = matrix else { return Ok(joint) };
        if matrix.len() != action || matrix.iter().any(|row| row.len() != parts) {
            let shape = format!("{} × {}", matrix.len(), matrix.first().map_or(0, Vec::len));
            return Err(Error::config(
                "credit",
                shape,
                "it must have a row per action and a column per part of the reward",
            ));
        }
        let weights = matrix.concat();
        match weights.iter().all(|weight| *weight == 1.0) {
            true => Ok(joint),
            false => Ok(Self { size: 1, kinds: (0..action).collect(), weights, ..joint }),
        }
    }

    /// Returns the credit of a graph network's building, with a part for every node. The actions of all nodes of a type
    /// form one kind, and so do their parts. `owners` has the owner of every action.
    pub(crate) fn by_node(spaces: &Spaces, plan: &NodePlan, graph: &Graph, owners: &[Owner]) -> Self {
        let (nodes, places) = (graph.nodes(), part_places(spaces, Some(plan), graph.nodes()));
        let mut weights = vec![0.0; graph.actions.len() * nodes];
        for (weights, credits) in weights.chunks_exact_mut(nodes).zip(credit(spaces, owners)) {
            places.iter().zip(credits).for_each(|(place, credit)| weights[*place] = credit);
        }
        Self::of_nodes(graph, &places, weights)
    }

    /// Returns the credit of a building with a part for every node. `penalized` lists the nodes with a penalty, energy
    /// last; the weights are actions × nodes.
    pub(crate) fn of_nodes(graph: &Graph, penalized: &[usize], weights: Vec<f32>) -> Self {
        let kind = |node: usize| penalized.contains(&node).then(|| graph.types[node]);
        Self {
            size: 1,
            kinds: graph.actions.iter().map(|place| place.number).collect(),
            parts: (0..graph.nodes()).map(kind).collect(),
            weights,
            energy: penalized[penalized.len() - 1],
        }
    }

    /// Returns the number of groups.
    pub fn groups(&self) -> usize {
        self.kinds.len()
    }

    /// Returns the kind of each group.
    pub fn kinds(&self) -> &[usize] {
        &self.kinds
    }

    /// Returns the kind of each part.
    pub fn parts(&self) -> &[Option<usize>] {
        &self.parts
    }

    /// Returns the part of the energy penalty.
    pub fn energy(&self) -> usize {
        self.energy
    }

    /// Returns the actions of a group, in a building with this many actions.
    pub fn actions(&self, group: usize, count: usize) -> Range<usize> {
        group * self.size..((group + 1) * self.size).min(count)
    }

    /// Writes the advantages of the groups of a step from the advantages of the parts.
    pub fn assign(&self, of_parts: &[f32], of_groups: &mut [f32]) {
        for (advantage, weights) in of_groups.iter_mut().zip(self.weights.chunks_exact(self.parts.len())) {
            *advantage = weights.iter().zip(of_parts).map(|(weight, part)| weight * part).sum();
        }
    }
}

/// Returns the weight of each part of a reward (column: controlled zones, then energy) in the advantage of each action
/// (row), given the owners of the actions. A zone's part counts for its own actions and for the air handler that serves
/// it, energy for all.
pub(crate) fn credit(spaces: &Spaces, owners: &[Owner]) -> Vec<Vec<f32>> {
    let zones: Vec<usize> = spaces.controlled_zones().collect();
    let layouts: Vec<_> = spaces.building.laid_out_systems().map(|(_, layout)| layout).collect();
    let serves = |owner: &Owner, zone: usize| match owner {
        Owner::Zone(own) => *own == zone,
        Owner::AirLoop(system) => layouts[*system].zones.iter().any(|served| served.index == zone),
        Owner::Weather | Owner::Calendar | Owner::Energy => false,
    };
    let row = |owner: &Owner| {
        let zones = zones.iter().map(|zone| f32::from(u8::from(serves(owner, *zone))));
        zones.chain([1.0]).collect()
    };
    owners.iter().map(row).collect()
}

/// Returns the index of the part of each controlled zone, and then of energy, among the parts of a reward. If there is
/// only one part, it holds all of them.
pub(crate) fn part_places(spaces: &Spaces, plan: Option<&NodePlan>, parts: usize) -> Vec<usize> {
    let zones = spaces.controlled_zones();
    match plan {
        _ if parts == 1 => vec![0; zones.count() + 1],
        None => (0..=zones.count()).collect(),
        Some(plan) => {
            let node = |owner: Owner| plan.nodes.iter().position(|node| node.owner() == owner);
            let owners = zones.map(Owner::Zone).chain([Owner::Energy]);
            owners
                .map(|owner| node(owner).expect("every controlled zone has a node, and so has energy"))
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTHS: Widths = Widths { observation: 1, action: 3, parts: 2, nodes: 1 };

    #[test]
    fn actions_have_the_advantages_of_their_parts() {
        let matrix = [vec![1.0, 0.0], vec![0.0, 1.0], vec![1.0, 0.5]];
        let credit = Credit::new(Some(&matrix), WIDTHS).unwrap();
        let mut advantages = [0.0; 3];
        credit.assign(&[1.0, 10.0], &mut advantages);
        assert_eq!(advantages, [1.0, 10.0, 6.0]);
        assert_eq!((credit.groups(), credit.actions(2, 3)), (3, 2..3));
    }

    #[test]
    fn a_matrix_of_ones_is_one_group_of_all_actions() {
        let ones = vec![vec![1.0, 1.0]; 3];
        let credit = Credit::new(Some(&ones), WIDTHS).unwrap();
        assert_eq!(credit, Credit::new(None, WIDTHS).unwrap());
        assert_eq!((credit.groups(), credit.actions(0, 3)), (1, 0..3));
        assert!(Credit::new(Some(&ones[..2]), WIDTHS).is_err());
    }
}
