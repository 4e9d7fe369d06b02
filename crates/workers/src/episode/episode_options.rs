//! How an episode is run.

/// How an episode is run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EpisodeOptions {
    /// Steps after which the episode is truncated; the whole run period if `None`.
    pub max_steps: Option<usize>,
    /// Index of the processor to pin the worker to, among those it may use; `None` for no pinning.
    pub processor: Option<u32>,
    /// Whether the engine finishes its run after the last step, for an [`EpisodeReport`](crate::EpisodeReport).
    /// Otherwise, the worker ends immediately.
    pub finish_run: bool,
}
