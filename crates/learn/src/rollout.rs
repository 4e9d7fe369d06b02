//! Steps of several environments, as a learner reads them.

use std::sync::Arc;

use b2b_agent::network::Graph;

use crate::credit::Credit;
use crate::error::{Error, Result};

pub use crate::widths::Widths;

/// Steps that a policy has made in several environments: the same number in each.
///
/// Arrays have a row for each environment, with its steps one after another. Rewards are scaled already.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rollout {
    /// Number of environments.
    pub environments: usize,
    /// Steps of each.
    pub steps: usize,
    /// Observation before each step: environments × steps × width.
    pub observations: Vec<f32>,
    /// Action of each step, from -1 to 1 (a Gaussian policy may exceed this): environments × steps × width.
    pub actions: Vec<f32>,
    /// Reward of each step, by its parts: environments × steps × parts. Their sum is the reward.
    pub rewards: Vec<f32>,
    /// Observation after the last step: environments × width.
    pub next: Vec<f32>,
    /// Steps that ended an episode, ordered by environment and step.
    pub ends: Vec<End>,
    /// Buildings, for a graph network: ordered by environment and step, each environment from its first step on. Rows
    /// of a building that is smaller than the widths are padded with zeros.
    pub scenes: Vec<Scene>,
    /// States of a recurrent actor before the first step of each environment: environments × width; empty for other
    /// actors.
    pub states: Vec<f32>,
    /// Steps before which a recurrent network forgets, the first of an episode with a new memory: environment and step.
    pub starts: Vec<(usize, usize)>,
    /// With mirrored noise, the number of first steps in which the two environments of each pair are at the same step
    /// of the same episode and have opposite noise.
    pub pairs: Vec<usize>,
}

/// The building of an environment from a step on.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Environment.
    pub environment: usize,
    /// First step of the rollout in the building.
    pub step: usize,
    /// The building.
    pub graph: Arc<Graph>,
    /// Credit of its actions.
    pub credit: Arc<Credit>,
}

/// The end of an episode, a truncation: its value is bootstrapped.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// Environment.
    pub environment: usize,
    /// Index of the last step of the episode.
    pub step: usize,
    /// Last observation of the episode. The next row belongs to the next episode.
    pub observation: Vec<f32>,
}

impl Rollout {
    /// Returns the number of steps of all environments.
    pub fn rows(&self) -> usize {
        self.environments * self.steps
    }

    /// Resizes the arrays for these environments, steps and widths, and clears the lists.
    pub(crate) fn resize(&mut self, environments: usize, steps: usize, widths: Widths) {
        (self.environments, self.steps) = (environments, steps);
        let rows = self.rows();
        self.observations.resize(rows * widths.observation, 0.0);
        self.actions.resize(rows * widths.action, 0.0);
        self.rewards.resize(rows * widths.parts, 0.0);
        self.next.resize(environments * widths.observation, 0.0);
        self.ends.clear();
        self.scenes.clear();
        self.pairs.clear();
        self.states.clear();
        self.starts.clear();
    }

    /// Zeros the padding of smaller buildings.
    pub(crate) fn clear_padding(&mut self, widths: Widths) {
        let Self { steps, observations, actions, next, ends, scenes, .. } = self;
        for (number, scene) in scenes.iter().enumerate() {
            let environment = scene.environment;
            let following = scenes.get(number + 1).filter(|next| next.environment == environment);
            let end = following.map_or(*steps, |next| next.step);
            let clear = |values: &mut [f32], width: usize, used: usize| {
                let rows = (environment * *steps + scene.step) * width..(environment * *steps + end) * width;
                values[rows].chunks_exact_mut(width).for_each(|row| row[used..].fill(0.0));
            };
            let (observed, width) = (scene.graph.width(), widths.observation);
            clear(observations, width, observed);
            clear(actions, widths.action, scene.graph.actions.len());
            if end == *steps {
                next[environment * width + observed..(environment + 1) * width].fill(0.0);
            }
            for last in ends.iter_mut().filter(|last| last.environment == environment) {
                if (scene.step..end).contains(&last.step) {
                    last.observation[observed..].fill(0.0);
                }
            }
        }
    }

    /// Returns the mean penalty of a step: the negated mean reward, over all parts.
    pub fn mean_penalty(&self) -> f64 {
        -self.rewards.iter().map(|reward| f64::from(*reward)).sum::<f64>() / self.rows() as f64
    }

    /// Returns energy's share of the mean penalty of a step, for rewards with this number of parts. For flat networks
    /// energy is the last part.
    pub(crate) fn mean_energy_penalty(&self, parts: usize) -> f64 {
        let energy = |(row, rewards): (usize, &[f32])| {
            let scene = self.scenes.get(self.scene_of(row / self.steps, row % self.steps));
            f64::from(rewards[scene.map_or(parts - 1, |scene| scene.credit.energy())])
        };
        -self.rewards.chunks_exact(parts).enumerate().map(energy).sum::<f64>() / self.rows() as f64
    }

    /// Returns the number of the scene of a step of an environment. Without graphs it is 0.
    pub fn scene_of(&self, environment: usize, step: usize) -> usize {
        let later = |scene: &Scene| (scene.environment, scene.step) > (environment, step);
        self.scenes.iter().position(later).unwrap_or(self.scenes.len()).saturating_sub(1)
    }

    /// Checks the lengths of the arrays, the starts, and the order of the ends.
    ///
    /// # Errors
    /// When an array has another length than its counts and these widths, or a start or an end is outside the rollout,
    /// or an end out of order.
    pub fn check(&self, widths: Widths) -> Result<()> {
        let rows = self.rows();
        let lengths = [
            ("observations", self.observations.len(), rows * widths.observation),
            ("actions", self.actions.len(), rows * widths.action),
            ("rewards", self.rewards.len(), rows * widths.parts),
            ("next", self.next.len(), self.environments * widths.observation),
        ];
        for (name, length, expected) in lengths {
            if length != expected {
                return Err(Error::Rollout { name, length, expected });
            }
        }
        self.ends.iter().try_for_each(|end| end.check(self, widths))?;
        let is_outside = |start: &&(usize, usize)| start.0 >= self.environments || start.1 >= self.steps;
        if let Some((environment, step)) = self.starts.iter().find(is_outside).copied() {
            return Err(Error::Step { name: "starts", environment, step });
        }
        let place = |end: &End| (end.environment, end.step);
        match self.ends.windows(2).find(|pair| place(&pair[0]) >= place(&pair[1])) {
            Some([_, end]) => Err(end.misplaced()),
            _ => Ok(()),
        }
    }
}

impl End {
    fn check(&self, rollout: &Rollout, widths: Widths) -> Result<()> {
        let (length, expected) = (self.observation.len(), widths.observation);
        if self.environment >= rollout.environments || self.step >= rollout.steps {
            return Err(self.misplaced());
        }
        if length != expected {
            return Err(Error::Rollout { name: "observation of an end", length, expected });
        }
        Ok(())
    }

    fn misplaced(&self) -> Error {
        Error::Step { name: "ends", environment: self.environment, step: self.step }
    }
}
