//! Options of workers.

use std::path::PathBuf;
use std::time::Duration;

use super::launcher::Launcher;

/// How a set of [`Workers`](super::Workers) is run.
#[derive(Clone, Debug)]
pub struct WorkerOptions {
    /// How processes are started.
    pub launcher: Launcher,
    /// The engine's library.
    pub library: PathBuf,
    /// Memory that templates without episodes may hold, bytes. The least recently used is ended first.
    pub template_memory: u64,
    /// Templates that are prepared at the same time; others wait for their turn, those that an episode waits for first.
    pub preparations: usize,
    /// A worker that takes longer for a step, or to copy itself, counts as hung and is killed; its episode is lost.
    /// Only time in which its owner waits for it counts, so not that in which the owner was stopped itself.
    pub step_time_limit: Duration,
    /// A template that takes longer to size and warm up its building counts as hung and is killed. A template that
    /// hangs or dies is started once more. Time counts as for a step.
    pub preparation_time_limit: Duration,
    /// Called now and then while waiting; when true, waiting ends with [`Error::Interrupted`](b2b_env::Error::Interrupted).
    pub interrupted: fn() -> bool,
}

impl WorkerOptions {
    /// 2 GiB for templates, a preparation per processor, half a minute for a step, ten minutes for a preparation, and no
    /// interrupts.
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
