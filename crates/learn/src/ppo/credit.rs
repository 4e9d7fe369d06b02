//! Credit: the parts of the reward that count in the advantage of each action.
//!
//! Actions form groups. The probability ratio of PPO is that of all actions of a group together, and each group has its own
//! advantage.
//!
//! - Ordinary PPO has one group of all actions, whose advantage is that of the sum of the parts.
//! - With a credit matrix, each action is a group. Its advantage is the sum of those of the parts, weighted by its row. A matrix
//!   of ones is ordinary PPO.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::rollout::Widths;

/// The groups of actions, and the weights of their advantages.
#[derive(Clone, Debug, PartialEq)]
pub struct Credit {
    groups: usize,
    /// Actions of a group.
    size: usize,
    /// Number of parts.
    parts: usize,
    /// Weights, groups × parts.
    weights: Vec<f32>,
}

impl Credit {
    /// Returns the credit of a matrix, actions × parts.
    ///
    /// # Errors
    /// When the matrix has another shape.
    pub fn new(matrix: Option<&[Vec<f32>]>, widths: Widths) -> Result<Self> {
        let Widths { action, parts, .. } = widths;
        let joint = Self { groups: 1, size: action, parts, weights: vec![1.0; parts] };
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
            false => Ok(Self { groups: action, size: 1, parts, weights }),
        }
    }

    /// Returns the number of groups.
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// Returns the actions of a group, in a building that has this many.
    pub fn actions(&self, group: usize, count: usize) -> Range<usize> {
        group * self.size..((group + 1) * self.size).min(count)
    }

    /// Writes the advantages of the groups, rows × groups, from those of the parts, rows × parts.
    pub fn assign(&self, of_parts: &[f32], of_groups: &mut [f32]) {
        let rows = of_parts.chunks_exact(self.parts).zip(of_groups.chunks_exact_mut(self.groups));
        for (of_parts, of_groups) in rows {
            for (advantage, weights) in of_groups.iter_mut().zip(self.weights.chunks_exact(self.parts)) {
                *advantage = weights.iter().zip(of_parts).map(|(weight, part)| weight * part).sum();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTHS: Widths = Widths { observation: 1, action: 3, parts: 2 };

    #[test]
    fn actions_have_the_advantages_of_their_parts() {
        let matrix = [vec![1.0, 0.0], vec![0.0, 1.0], vec![1.0, 0.5]];
        let credit = Credit::new(Some(&matrix), WIDTHS).unwrap();
        let mut advantages = [0.0; 6];
        credit.assign(&[1.0, 10.0, 2.0, 20.0], &mut advantages);
        assert_eq!(advantages, [1.0, 10.0, 6.0, 2.0, 20.0, 12.0]);
        assert_eq!(credit.actions(2, 3), 2..3);
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
