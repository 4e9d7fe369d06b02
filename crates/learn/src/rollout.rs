//! Steps of several environments, as a learner reads them.

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
    /// Action of each step, from -1 to 1 or, of a Gaussian policy, beyond: environments × steps × width.
    pub actions: Vec<f32>,
    /// Reward of each step, by its parts: environments × steps × parts. Their sum is the reward.
    pub rewards: Vec<f32>,
    /// Observation after the last step: environments × width.
    pub next: Vec<f32>,
    /// Steps that ended an episode, ordered by environment and step.
    pub ends: Vec<End>,
}

/// The end of an episode. It is a truncation: the return does not end there.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// Environment.
    pub environment: usize,
    /// Index of the last step of the episode.
    pub step: usize,
    /// Observation after that step, of the episode that ended. The row of the next step is of the next episode.
    pub observation: Vec<f32>,
}
