//! Steps as PPO learns from them: those of a rollout, and those of a minibatch.

use crate::rollout::{Rollout, Widths};

/// Rows of steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    /// Observations: rows × width.
    pub observations: Vec<f32>,
    /// Building of each row among the scenes of the rollout.
    pub scenes: Vec<usize>,
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
    /// Copies the observations and actions of a rollout.
    pub fn read(&mut self, rollout: &Rollout) {
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
        gather(&mut self.observations, &all.observations, rows, widths.observation);
        self.scenes.clear();
        self.scenes.extend(rows.iter().map(|row| all.scenes[*row]));
        gather(&mut self.actions, &all.actions, rows, widths.action);
        gather(&mut self.old, &all.old, rows, groups);
        gather(&mut self.advantages, &all.advantages, rows, groups);
        gather(&mut self.returns, &all.returns, rows, widths.parts);
    }

    /// Brings the advantages of each group to mean 0 and deviation 1, as Stable-Baselines3 does. One row stays as it is.
    pub fn normalize_advantages(&mut self, groups: usize) {
        let rows = self.advantages.len() / groups;
        for group in 0..if rows > 1 { groups } else { 0 } {
            let of_group =
                || self.advantages.iter().skip(group).step_by(groups).map(|value| f64::from(*value));
            let mean = of_group().sum::<f64>() / rows as f64;
            let variance = of_group().map(|value| (value - mean).powi(2)).sum::<f64>() / (rows - 1) as f64;
            let scale = 1.0 / (variance.sqrt() + 1e-8);
            for value in self.advantages.iter_mut().skip(group).step_by(groups) {
                *value = ((f64::from(*value) - mean) * scale) as f32;
            }
        }
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
    fn advantages_are_normalized_by_group() {
        let mut samples = Samples { advantages: vec![1.0, 10.0, 3.0, 10.0, 5.0, 40.0], ..Samples::default() };
        samples.normalize_advantages(2);
        let expected = [-1.0, -0.57735, 0.0, -0.57735, 1.0, 1.1547];
        assert!(samples.advantages.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-5));
    }
}
