//! Options of workers.

use std::path::PathBuf;
use std::time::Duration;

use super::launcher::Launcher;

/// Options of a set of [`Workers`](crate::Workers).
#[derive(Clone, Debug)]
pub struct WorkerOptions {
    /// How processes are started.
    pub launcher: Launcher,
    /// The engine's library.
    pub library: PathBuf,
    /// Memory limit of templates, bytes. Above it, templates without episodes end, the least recently used first.
    pub template_memory: u64,
    /// Number of templates prepared at the same time. Others are queued; templates that an episode waits for come
    /// first.
    pub preparations: usize,
    /// Limit of a step or a copy. A slower worker counts as hung and is killed, and its episode is lost. Only time in
    /// which its owner waits counts, not time in which the owner is stopped.
    pub step_time_limit: Duration,
    /// Limit of sizing and warm-up. A slower template counts as hung and is killed. A template that hangs or dies is
    /// restarted once. Time counts as for a step.
    pub preparation_time_limit: Duration,
    /// Called repeatedly while waiting; `true` ends the wait with [`Error::Interrupted`](b2b_env::Error::Interrupted).
    pub interrupted: fn() -> bool,
}

impl WorkerOptions {
    /// Creates the defaults: 2 GiB for templates, a preparation per processor, half a minute for a step, ten minutes
    /// for a preparation, and no interrupts.
    pub fn new(launcher: Launcher, library: impl Into<PathBuf>) -> Self {
        Self {
            launcher,
            library: library.into(),
            template_memory: 2 << 30,
            preparations: std::thread::available_parallelism().map_or(1, usize::from),
            step_time_limit: Duration::from_secs(30),
            preparation_time_limit: Duration::from_secs(600),
            interrupted: || false,
        }
    }
}
