//! How an episode is run.

/// How an episode is run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EpisodeOptions {
    /// Steps after which the episode is truncated; the whole run period if `None`.
    pub max_steps: Option<usize>,
    /// Index, among the processors that the worker may use, of the one it is pinned to; not pinned if `None`.
    pub processor: Option<u32>,
    /// Whether the engine finishes its run after the last step, so that there is an
    /// [`EpisodeReport`](super::EpisodeReport). Otherwise the worker ends at once.
    pub finish_run: bool,
}
