//! Statistics of a batch of environments.

use std::time::Duration;

/// Counters of a [`VecEnv`](super::VecEnv) since it was created.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Episodes begun.
    pub episodes: u64,
    /// Episodes of another building than the one before in the same environment.
    pub building_changes: u64,
    /// Episodes, other than the first after [`VecEnv::reset`](super::VecEnv::reset), whose building was not prepared when
    /// they were to begin.
    pub waits: u64,
    /// Total time of these waits, of each environment.
    pub waited: Duration,
}
