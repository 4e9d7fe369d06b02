//! The actions that this program carries out in separate processes: the functions of its commands, with their
//! arguments as JSON.

use anyhow::{Error, Result};
use b2b_experiment::{ACTION, Benchmark, Measurement, Program};
use b2b_workers::Actions;

use crate::terminal::interrupt;
use crate::{bench, experiment, program, tune, with_remedy};

/// The actions, by name.
pub(crate) const ACTIONS: Actions = Actions(&[
    (ACTION, |order| carry_out(|| job(order))),
    ("experiment", |order| carry_out(|| experiment::carry_out(&serde_json::from_str(order)?))),
    ("tune", |order| carry_out(|| tune::carry_out(&serde_json::from_str(order)?))),
    (bench::SINGLE, |order| carry_out(|| bench::serve_single(&serde_json::from_str(order)?))),
]);

/// Carries out an action. It ends with the process that ordered it.
fn carry_out(action: impl FnOnce() -> Result<String>) -> Result<String, String> {
    let done = interrupt::listen_with_owner().and_then(|()| action());
    done.map_err(|error| with_remedy(&error))
}

/// Carries out a part of a job of an experiment.
fn job(order: &str) -> Result<String> {
    interrupt::be_patient();
    let program = Program { launcher: program::launcher(), interrupted: interrupt::requested, measure };
    program.carry_out(order).map_err(Error::from_boxed)
}

fn measure(measurement: &Measurement) -> Result<String, Box<dyn std::error::Error + Send + Sync>> {
    let Benchmark::Speed = measurement.benchmark;
    Ok(bench::speed_json(&measurement.types)?)
}
