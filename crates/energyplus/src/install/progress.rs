//! Progress and cancellation of an installation.

use std::ops::ControlFlow;

use super::error::{Error, Result};

/// Receiver of the progress of one or more tasks: for each, `begin`, any number of calls of `advance`, and `end`.
///
/// During a task, `advance` is called about every 50 ms or more often, even without progress, so that cancellation is
/// prompt.
pub trait Progress {
    /// Called at the start of a task; `total_bytes` is 0 if unknown.
    fn begin(&mut self, what: &str, total_bytes: u64) {
        let _ = (what, total_bytes);
    }

    /// Called with the number of bytes since `begin`. [`ControlFlow::Break`] cancels.
    fn advance(&mut self, bytes: u64) -> ControlFlow<()> {
        let _ = bytes;
        ControlFlow::Continue(())
    }

    /// Called at the end of a task; not after an error.
    fn end(&mut self) {}
}

/// Ignores progress and never cancels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quiet;

impl Progress for Quiet {}

/// A task whose progress is reported.
pub(super) struct Task<'a> {
    progress: &'a mut dyn Progress,
    what: String,
}

impl<'a> Task<'a> {
    pub(super) fn begin(progress: &'a mut dyn Progress, what: String, total_bytes: u64) -> Self {
        progress.begin(&what, total_bytes);
        Self { progress, what }
    }

    pub(super) fn advance(&mut self, bytes: u64) -> Result<()> {
        match self.progress.advance(bytes) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled { what: self.what.clone() }),
        }
    }

    pub(super) fn end(self) {
        self.progress.end();
    }
}
