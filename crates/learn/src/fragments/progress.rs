//! Progress of one environment in a collection.

use std::sync::Arc;

use b2b_env::Spaces;

use super::building::GraphBuilding;
use crate::comfort_weights::ComfortWeights;
use crate::error::Result;
use crate::rollout::{End, Scene};

/// Progress of one environment in a collection.
#[derive(Clone, Debug)]
pub(super) struct EnvironmentProgress {
    pub(super) phase: FragmentPhase,
    /// Steps of the rollout so far.
    pub(super) done: usize,
    /// This environment's fragments in the rollout.
    pub(super) fragments: u64,
    /// Factor of the rewards of the episode in progress.
    pub(super) scale: f32,
    /// The evaluations whose multipliers of discomfort count in the episode, once they are known.
    pub(super) comfort: Option<Vec<usize>>,
    /// Attributes that the agent observes of its building.
    pub(super) attributes: Vec<f64>,
    /// Reward factors in the rollout, each with the step from which it applies.
    pub(super) scales: Vec<(usize, f32)>,
    pub(super) ends: Vec<End>,
    /// Building of the episode in progress, for a graph network.
    pub(super) building: Option<GraphBuilding>,
    /// Buildings in the rollout, each with the step from which it applies.
    pub(super) scenes: Vec<Scene>,
    /// Episodes begun since the first reset.
    pub(super) episodes: u64,
    /// Actions of the episode in progress.
    pub(super) actions: Vec<f32>,
    /// State of a recurrent actor after the last fragment.
    pub(super) state: Vec<f32>,
    /// That state when the rollout began.
    pub(super) first_state: Vec<f32>,
    /// Steps of the rollout before which the actor forgets.
    pub(super) starts: Vec<usize>,
    /// Where the rollout began: see [`EnvironmentProgress::place`].
    pub(super) began: (u64, usize),
    pub(super) lost_in_a_row: u32,
    /// Time spent on actions and on all steps of the rollout, s.
    pub(super) times: [f32; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FragmentPhase {
    /// Ready for a fragment.
    Ready,
    /// In a fragment.
    Running,
    /// Between two episodes.
    Starting,
}

impl EnvironmentProgress {
    pub(super) fn new(scale: f32, building: Option<GraphBuilding>, attributes: Vec<f64>) -> Self {
        Self {
            building,
            scenes: Vec::new(),
            phase: FragmentPhase::Ready,
            done: 0,
            fragments: 0,
            scale,
            comfort: None,
            attributes,
            scales: Vec::new(),
            ends: Vec::new(),
            episodes: 1,
            actions: Vec::new(),
            state: Vec::new(),
            first_state: Vec::new(),
            starts: Vec::new(),
            began: (1, 0),
            lost_in_a_row: 0,
            times: [0.0; 2],
        }
    }

    /// Returns the multiplier of discomfort in the episode in progress.
    pub(super) fn comfort_weight(&mut self, weights: &ComfortWeights, spaces: &Spaces) -> Result<f32> {
        if self.comfort.is_none() {
            self.comfort = Some(weights.counting(&spaces.building.name, &spaces.episode)?);
        }
        Ok(weights.of(self.comfort.as_deref().unwrap_or_default()))
    }

    pub(super) fn begin_rollout(&mut self, environment: usize) {
        (self.done, self.fragments, self.times) = (0, 0, [0.0; 2]);
        self.began = self.place();
        self.ends.clear();
        self.scales.clear();
        self.scenes.clear();
        self.first_state.clone_from(&self.state);
        self.starts.clear();
        self.begin_scene(environment);
    }

    /// Empties the memory of a recurrent actor before the first step of an episode, unless it spans episodes and this
    /// is not the first of them.
    pub(super) fn begin_memory(&mut self, memory_episodes: u64) {
        if self.forgets(memory_episodes) {
            self.state.fill(0.0);
            self.starts.retain(|step| *step < self.done);
            self.starts.push(self.done);
        }
    }

    /// Returns whether the next step begins with an empty memory, or would if the next episode had begun.
    pub(super) fn forgets(&self, memory_episodes: u64) -> bool {
        let (episode, actions) = self.place();
        actions == 0 && (episode - 1).is_multiple_of(memory_episodes)
    }

    /// Records the scale and building from this step on.
    pub(super) fn begin_scene(&mut self, environment: usize) {
        self.scales.push((self.done, self.scale));
        if let Some(GraphBuilding { graph, credit, .. }) = &self.building {
            self.scenes.retain(|scene| scene.step < self.done);
            let (graph, credit) = (Arc::clone(graph), Arc::clone(credit));
            self.scenes.push(Scene { environment, step: self.done, graph, credit });
        }
    }

    /// Returns the number of the episode in progress, or of the next one if it is over, and the length of its actions
    /// so far.
    pub(super) fn place(&self) -> (u64, usize) {
        match self.phase {
            FragmentPhase::Starting => (self.episodes + 1, 0),
            FragmentPhase::Ready | FragmentPhase::Running => (self.episodes, self.actions.len()),
        }
    }

    /// Returns the number of steps from the start of the rollout during which this environment and another with the same
    /// episodes are certain to be at the same step of the same episode.
    pub(super) fn in_step_with(&self, other: &Self, steps: usize) -> usize {
        let ends = |progress: &Self| -> Vec<usize> { progress.ends.iter().map(|end| end.step + 1).collect() };
        let (own, others) = (ends(self), ends(other));
        if self.began == other.began && self.place() == other.place() && own == others {
            return steps;
        }
        // An episode was lost, in this rollout or before. Both are in step up to the last end they share.
        let shared = own.iter().zip(&others).take_while(|(own, other)| own == other).last();
        shared.filter(|_| self.began == other.began).map_or(0, |(step, _)| *step)
    }

    /// Multiplies the rewards of the rollout by the factors of their steps.
    pub(super) fn scale_rewards(&self, rewards: &mut [f32], parts: usize) {
        for (index, (from, scale)) in self.scales.iter().enumerate() {
            let to = self.scales.get(index + 1).map_or(rewards.len(), |(step, _)| step * parts);
            rewards[from * parts..to].iter_mut().for_each(|reward| *reward *= scale);
        }
    }
}
