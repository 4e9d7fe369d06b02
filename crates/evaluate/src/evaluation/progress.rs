//! Progress of an evaluation.

/// Observes the progress of an evaluation. Called from every thread.
pub trait Progress: Sync {
    /// Episodes of `days` simulated days in total are about to run; `what` is `episodes` or `baselines`.
    fn begin(&self, _what: &str, _episodes: usize, _days: u64) {}

    /// A simulated day ended.
    fn day(&self) {}

    /// A note on how the model of a building was imported.
    fn note(&self, _building: &str, _note: &str) {}

    /// An episode ended or was lost.
    fn episode(&self) {}
}

/// Ignores progress.
impl Progress for () {}
