//! Training of agents.

use std::path::Path;
use std::thread::available_parallelism;

use b2b_learn::train::{RunOptions, RunSummary, TrainConfig};
use b2b_workers::Launcher;

use crate::Result;
use crate::builder::hosted_catalog;

/// Trains an agent in a folder like `b2b train`, or continues the folder's run.
/// [`Agent::read`](crate::agent::Agent::read) then reads the agent from the folder. Workers start this program again,
/// so call [`run_if_worker`](crate::run_if_worker) first in `main`. For progress reports and interrupts, call
/// [`learn::train::train`](crate::learn::train::train) with your own [`RunOptions`].
///
/// # Errors
/// [`Error::Training`](crate::Error::Training) for an invalid configuration, a folder that holds another run, or a
/// failure during training; errors from finding the engine.
pub fn train(config: &TrainConfig, folder: impl AsRef<Path>) -> Result<RunSummary> {
    let options = RunOptions {
        out: folder.as_ref().to_owned(),
        catalog: hosted_catalog()?,
        launcher: Launcher::this_program()?,
        jobs: available_parallelism().map_or(1, usize::from),
        interrupted: || false,
        monitor: &mut (),
    };
    Ok(b2b_learn::train::train(config, options)?)
}
