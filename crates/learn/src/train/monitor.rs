//! Reports on a run in progress.

use super::progress::ProgressRow;

/// Watches a run.
pub trait Monitor {
    /// A stage begins, such as `computing baselines`.
    fn stage(&mut self, _what: &str) {}

    /// An evaluation of the agent begins, after this many environment steps.
    fn evaluating(&mut self, _steps: u64) {}

    /// The updates begin, after this many environment steps.
    fn learning(&mut self, _steps: u64) {}

    /// An update was made.
    fn update(&mut self, _row: &ProgressRow) {}

    /// Something was not saved, or went wrong without ending the run.
    fn warn(&mut self, _text: &str) {}
}

impl Monitor for () {}
