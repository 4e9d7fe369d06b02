//! The last decision of an agent in an episode.

/// What the agent did last in the episode, and how it was rewarded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Past<'a> {
    /// Its last action, in [-1, 1]; 0 before the first.
    pub(crate) action: &'a [f32],
    /// Sum of the environment's rewards in the steps of its last decision.
    pub(crate) reward: f64,
    /// Whether it has not acted yet.
    pub(crate) is_first: bool,
}
