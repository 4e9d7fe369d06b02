//! Starting this program again: as a worker, or for an action such as a job of an experiment.

pub(crate) mod prepare;
pub(crate) mod weather;

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;

use anyhow::Result;
use b2b_dataset::Catalog;

use crate::terminal::progress::Download;

/// A program that calls [`run`](crate::run), and the arguments that precede `b2b`'s own.
#[derive(Clone, Debug)]
pub struct Program {
    executable: PathBuf,
    arguments: Vec<OsString>,
}

static THIS: OnceLock<Program> = OnceLock::new();

impl Program {
    /// Creates a program without leading arguments.
    pub fn new(executable: impl Into<PathBuf>) -> Self {
        Self { executable: executable.into(), arguments: Vec::new() }
    }

    /// Adds an argument before `b2b`'s own, as an interpreter needs.
    #[must_use]
    pub fn argument(mut self, argument: impl Into<OsString>) -> Self {
        self.arguments.push(argument.into());
        self
    }

    /// Registers it as this program. Only the first call has an effect.
    pub(crate) fn set(self) {
        let _ = THIS.set(self);
    }

    fn this() -> &'static Self {
        THIS.get().expect("`run` sets it before a command begins")
    }
}

/// Loads the engine, which is downloaded if it is missing. Worker processes read and size models with it, so a crash is
/// an error.
pub fn catalog(download: &mut Download) -> Result<Catalog> {
    let catalog = Catalog::open(download)?;
    let catalog = {
        let jobs = b2b_workers::Jobs::new(worker_options(catalog.library().path()));
        catalog.hosted_by(std::sync::Arc::new(jobs))
    };
    Ok(catalog)
}

/// Returns a launcher that starts this program as a worker.
pub fn launcher() -> b2b_workers::Launcher {
    let Program { executable, arguments } = Program::this();
    arguments.iter().fold(b2b_workers::Launcher::new(executable), |launcher, each| launcher.argument(each))
}

/// Returns the options of workers with this engine. An interrupt ends any wait for them.
pub fn worker_options(engine: &std::path::Path) -> b2b_workers::WorkerOptions {
    let options = b2b_workers::WorkerOptions::new(launcher(), engine);
    b2b_workers::WorkerOptions { interrupted: crate::terminal::interrupt::requested, ..options }
}
