//! How an installation tells what it does, and how it is cancelled.

use std::ops::ControlFlow;

use super::{Error, Result};

/// Told what is going on, in one or more begin / advance / end rounds.
///
/// `advance` is called every 50 ms or more often, also while nothing moves, so that cancelling is prompt.
pub trait Progress {
    /// Something starts; `total_bytes` is 0 when unknown.
    fn begin(&mut self, what: &str, total_bytes: u64) {
        let _ = (what, total_bytes);
    }

    /// So many bytes are done since `begin`. [`ControlFlow::Break`] cancels.
    fn advance(&mut self, bytes: u64) -> ControlFlow<()> {
        let _ = bytes;
        ControlFlow::Continue(())
    }

    /// It is done. Not called after an error.
    fn end(&mut self) {}
}

/// Shows nothing and never cancels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quiet;

impl Progress for Quiet {}

/// One begin / advance / end round.
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
