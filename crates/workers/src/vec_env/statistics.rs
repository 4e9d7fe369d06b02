//! Statistics of a batch of environments.

use std::time::Duration;

/// Counters of a [`VecEnv`](crate::VecEnv) since it was created.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Episodes begun.
    pub episodes: u64,
    /// Episodes with another building than the previous episode of the environment.
    pub building_changes: u64,
    /// Episodes, other than the first after [`VecEnv::reset`](crate::VecEnv::reset), whose building was not prepared in
    /// time.
    pub waits: u64,
    /// Total time of these waits, summed over the environments.
    pub waited: Duration,
}
