//! The samples of PPO: the steps of a rollout and of a minibatch.

use std::sync::Arc;

use crate::credit::Credit;
use crate::rollout::{Rollout, Widths};

/// Rows of steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    /// Observations: rows × width.
    pub observations: Vec<f32>,
    /// Building of each row among the scenes of the rollout.
    pub scenes: Vec<usize>,
    /// Whether a network with a memory forgets before each row; empty for other networks.
    pub starts: Vec<bool>,
    /// States of actor and critic before the first step of each sequence: sequences × width.
    pub states: [Vec<f32>; 2],
    /// Actions: rows × width.
    pub actions: Vec<f32>,
    /// Log densities of the groups of actions, under the policy that made the steps: rows × groups.
    pub old: Vec<f32>,
    /// Advantages of the groups of actions: rows × groups.
    pub advantages: Vec<f32>,
    /// Returns of the parts of the reward, on the scale of the critic: rows × parts.
    pub returns: Vec<f32>,
}

impl Samples {
    /// Copies the observations and actions of a rollout and, for networks with a memory, where they forget.
    pub fn read(&mut self, rollout: &Rollout, remembers: bool) {
        self.starts.clear();
        if remembers {
            self.starts.resize(rollout.rows(), false);
            let rows = rollout.starts.iter().map(|(environment, step)| environment * rollout.steps + step);
            rows.for_each(|row| self.starts[row] = true);
        }
        self.observations.clone_from(&rollout.observations);
        self.actions.clone_from(&rollout.actions);
        self.scenes.clear();
        for environment in 0..rollout.environments {
            let of_step = |step| rollout.scene_of(environment, step);
            self.scenes.extend((0..rollout.steps).map(of_step));
        }
    }

    /// Copies rows of other samples.
    pub fn gather(&mut self, all: &Self, rows: &[usize], widths: Widths, groups: usize) {
        self.gather_steps(all, rows, widths);
        gather(&mut self.old, &all.old, rows, groups);
        gather(&mut self.advantages, &all.advantages, rows, groups);
        gather(&mut self.returns, &all.returns, rows, widths.parts);
    }

    /// Copies what was observed and done in rows of other samples.
    pub fn gather_steps(&mut self, all: &Self, rows: &[usize], widths: Widths) {
        gather(&mut self.observations, &all.observations, rows, widths.observation);
        self.scenes.clear();
        self.scenes.extend(rows.iter().map(|row| all.scenes[*row]));
        self.starts.clear();
        if !all.starts.is_empty() {
            self.starts.extend(rows.iter().map(|row| all.starts[*row]));
        }
        gather(&mut self.actions, &all.actions, rows, widths.action);
    }

    /// Copies the states of sequences of other samples, of actor and critic with these widths.
    pub fn gather_states(&mut self, all: &Self, sequences: &[usize], widths: [usize; 2]) {
        for ((own, all), width) in self.states.iter_mut().zip(&all.states).zip(widths) {
            gather(own, all, sequences, width);
        }
    }

    /// Normalizes the advantages of each kind of group to mean 0 and deviation 1, as Stable-Baselines3 does. A kind
    /// with only one advantage is left unchanged. `groups` is the width of a row.
    pub fn normalize_advantages(&mut self, groups: usize, credits: &[Arc<Credit>]) {
        let kinds = 1 + credits.iter().flat_map(|credit| credit.kinds()).max().copied().unwrap_or_default();
        let Self { advantages, scenes, .. } = self;
        let mut each = |apply: &mut dyn FnMut(usize, &mut f32)| {
            for (row, scene) in advantages.chunks_exact_mut(groups).zip(scenes.iter()) {
                row.iter_mut().zip(credits[*scene].kinds()).for_each(|(value, kind)| apply(*kind, value));
            }
        };
        let (mut counts, mut means) = (vec![0usize; kinds], vec![0.0; kinds]);
        each(&mut |kind, value| {
            counts[kind] += 1;
            means[kind] += f64::from(*value);
        });
        means.iter_mut().zip(&counts).for_each(|(mean, count)| *mean /= (*count).max(1) as f64);
        let mut squares = vec![0.0; kinds];
        each(&mut |kind, value| squares[kind] += (f64::from(*value) - means[kind]).powi(2));
        let scale = |(squares, count): (&f64, &usize)| {
            let variance = squares / count.saturating_sub(1) as f64;
            1.0 / (variance.sqrt() + 1e-8)
        };
        let scales: Vec<f64> = squares.iter().zip(&counts).map(scale).collect();
        each(&mut |kind, value| {
            if counts[kind] > 1 {
                *value = ((f64::from(*value) - means[kind]) * scales[kind]) as f32;
            }
        });
    }
}

fn gather(to: &mut Vec<f32>, from: &[f32], rows: &[usize], width: usize) {
    to.clear();
    rows.iter().for_each(|row| to.extend_from_slice(&from[row * width..(row + 1) * width]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advantages_are_normalized_by_kind() {
        let credit = |matrix: &[Vec<f32>]| {
            let widths = Widths { observation: 1, action: matrix.len(), parts: 2, nodes: 1 };
            Arc::new(Credit::new(Some(matrix), widths).unwrap())
        };
        let two = credit(&[vec![1.0, 0.0], vec![0.0, 1.0]]);
        let advantages = vec![1.0, 10.0, 3.0, 10.0, 5.0, 40.0];
        let mut samples = Samples { advantages, scenes: vec![0; 3], ..Samples::default() };
        samples.normalize_advantages(2, &[Arc::clone(&two)]);
        let expected = [-1.0, -0.57735, 0.0, -0.57735, 1.0, 1.1547];
        assert!(samples.advantages.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-5));
    }
}
