//! The configuration of an evaluation, and the state its threads share.

use b2b_base::parallel::Halt;
use b2b_dataset::Catalog;
use b2b_workers::Launcher;

use super::episode::EpisodePlan;
use super::finished::Outcome;
use super::progress::Progress;
use super::recording::Recorded;
use crate::policy::Policy;
use crate::{Error, Result};

/// How episodes are run, in parallel.
#[derive(Debug)]
pub struct Evaluation<'a> {
    /// Source of buildings.
    pub catalog: &'a Catalog,
    /// Starts worker processes.
    pub launcher: Launcher,
    /// Episodes that run at a time.
    pub jobs: usize,
    /// Polled at least once per simulated day; if true, the evaluation ends with [`Error::Interrupted`].
    pub interrupted: fn() -> bool,
}

/// State shared by the threads of an evaluation.
pub(super) struct Work<'a> {
    pub(super) episodes: &'a [(usize, &'a EpisodePlan)],
    pub(super) policy: &'a dyn Policy,
    pub(super) progress: &'a dyn Progress,
    pub(super) keep: &'a (dyn Fn(usize, Outcome) -> Result<()> + Sync),
    /// Called with every recorded episode before it is kept.
    pub(super) recorded: &'a (dyn Fn(usize, &Recorded<'_>) -> Result<()> + Sync),
    /// Set after an error that ends the evaluation, to stop the other threads.
    pub(super) halt: Halt,
    pub(super) interrupted: fn() -> bool,
}

impl Work<'_> {
    /// Errors if the evaluation is to stop.
    pub(super) fn check(&self) -> Result<()> {
        let halt = (self.interrupted)() || self.halt.is_set();
        if halt { Err(Error::Interrupted) } else { Ok(()) }
    }
}
