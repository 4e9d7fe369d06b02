//! Training of agents.

use std::path::Path;
use std::thread::available_parallelism;

use b2b_learn::train::{RunOptions, Summary, TrainConfig};
use b2b_workers::Launcher;

use crate::Result;
use crate::builder::catalog;

/// Trains an agent in a folder, as `b2b train` does, or continues the run that the folder has. The folder is the agent's then:
/// [`Agent::read`](crate::agent::Agent::read). Workers are this program started once more: call
/// [`run_if_worker`](crate::run_if_worker) first in `main`. For a progress report and interrupts, call
/// [`learn::train::train`](crate::learn::train::train) with [`RunOptions`] of your own.
///
/// # Errors
/// [`Error::Training`](crate::Error::Training) for an invalid configuration, a folder that holds another run, or a
/// failure during training; errors from finding the engine.
pub fn train(config: &TrainConfig, folder: impl AsRef<Path>) -> Result<Summary> {
    let options = RunOptions {
        out: folder.as_ref().to_owned(),
        catalog: catalog()?,
        launcher: Launcher::this_program()?,
        jobs: available_parallelism().map_or(1, usize::from),
        interrupted: || false,
        monitor: &mut (),
    };
    Ok(b2b_learn::train::train(config, options)?)
}
