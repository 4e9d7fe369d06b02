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
        let of_all = Moments::of(self, groups, credits, |_, kind| kind);
        self.each_advantage(groups, credits, |_, kind, value| of_all.normalize(kind, 0.0, value));
    }

    /// Normalizes the advantages of each kind of group in each building to mean 0 and deviation 1, but divides none by
    /// less than [`SMALLEST`] times the kind's deviation in all buildings. The only advantage of a kind in a building has
    /// the mean and the deviation of all buildings.
    pub fn balance_advantages(&mut self, groups: usize, credits: &[Arc<Credit>]) {
        let of_all = Moments::of(self, groups, credits, |_, kind| kind);
        let kinds = of_all.0.len();
        let of_each = Moments::of(self, groups, credits, |building, kind| building * kinds + kind);
        self.each_advantage(groups, credits, |building, kind, value| {
            let set = building * kinds + kind;
            match of_each.0[set].count {
                1 => of_all.normalize(kind, 0.0, value),
                _ => of_each.normalize(set, SMALLEST * of_all.0[kind].deviation, value),
            }
        });
    }

    /// Calls a function with the building, the kind of group and the value of each advantage.
    fn each_advantage(
        &mut self,
        groups: usize,
        credits: &[Arc<Credit>],
        mut apply: impl FnMut(usize, usize, &mut f32),
    ) {
        for (row, scene) in self.advantages.chunks_exact_mut(groups).zip(&self.scenes) {
            row.iter_mut().zip(credits[*scene].kinds()).for_each(|(value, kind)| apply(*scene, *kind, value));
        }
    }
}

/// Smallest deviation of advantages in a building, as a share of the deviation in all buildings.
const SMALLEST: f64 = 0.1;

/// The moments of a set of advantages.
#[derive(Clone, Default)]
struct Moment {
    count: usize,
    mean: f64,
    deviation: f64,
}

/// The moments of several sets of advantages.
struct Moments(Vec<Moment>);

impl Moments {
    /// Returns the moments of sets numbered by building and kind of group.
    fn of(
        samples: &mut Samples,
        groups: usize,
        credits: &[Arc<Credit>],
        number: impl Fn(usize, usize) -> usize,
    ) -> Self {
        let mut sets: Vec<Moment> = Vec::new();
        samples.each_advantage(groups, credits, |building, kind, value| {
            let set = number(building, kind);
            if sets.len() <= set {
                sets.resize(set + 1, Moment::default());
            }
            sets[set].count += 1;
            sets[set].mean += f64::from(*value);
        });
        sets.iter_mut().for_each(|set| set.mean /= set.count.max(1) as f64);
        samples.each_advantage(groups, credits, |building, kind, value| {
            let set = &mut sets[number(building, kind)];
            set.deviation += (f64::from(*value) - set.mean).powi(2);
        });
        sets.iter_mut().for_each(|set| {
            set.deviation = (set.deviation / set.count.saturating_sub(1).max(1) as f64).sqrt();
        });
        Self(sets)
    }

    /// Normalizes an advantage of a set, unless it is the only one.
    fn normalize(&self, set: usize, smallest: f64, value: &mut f32) {
        let Moment { count, mean, deviation } = self.0[set];
        if count > 1 {
            let scale = 1.0 / (deviation.max(smallest) + 1e-8);
            *value = ((f64::from(*value) - mean) * scale) as f32;
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

    /// Returns samples of one kind of group, with these buildings and advantages.
    fn samples(scenes: &[usize], advantages: &[f32]) -> (Samples, Vec<Arc<Credit>>) {
        let widths = Widths { observation: 1, action: 1, parts: 1, nodes: 1 };
        let credits = (0..=*scenes.iter().max().unwrap()).map(|_| Arc::new(Credit::joint(widths))).collect();
        let samples =
            Samples { advantages: advantages.to_vec(), scenes: scenes.to_vec(), ..Samples::default() };
        (samples, credits)
    }

    fn assert_near(advantages: &[f32], expected: &[f32]) {
        assert_eq!(advantages.len(), expected.len());
        assert!(advantages.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{advantages:?}");
    }

    #[test]
    fn balanced_advantages_have_the_same_deviation_in_every_building() {
        let (mut samples, credits) = samples(&[0, 0, 0, 1, 1, 1], &[10.0, 20.0, 30.0, -2.0, 0.0, 2.0]);
        samples.balance_advantages(1, &credits);
        assert_near(&samples.advantages, &[-1.0, 0.0, 1.0, -1.0, 0.0, 1.0]);
    }

    #[test]
    fn advantages_of_a_building_without_effect_are_not_blown_up() {
        let (mut samples, credits) = samples(&[0, 0, 1, 1], &[-1.0, 1.0, -1e-6, 1e-6]);
        samples.balance_advantages(1, &credits);
        let half = 0.5f32.sqrt();
        assert_near(&samples.advantages, &[-half, half, 0.0, 0.0]);
    }

    #[test]
    fn the_only_advantage_of_a_building_is_normalized_with_all() {
        let (mut samples, credits) = samples(&[0, 0, 1], &[-10.0, 10.0, 30.0]);
        samples.balance_advantages(1, &credits);
        let half = 0.5f32.sqrt();
        // Mean and deviation of all are 10 and 20.
        assert_near(&samples.advantages, &[-half, half, 1.0]);
    }

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
