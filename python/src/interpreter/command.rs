//! The command `b2b`, in an interpreter that has loaded only this extension module.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

use b2b_cli::Program;
use b2b_energyplus::install::use_packages_in;
use b2b_workers::{ActionEnd, ActionProcess};
use pyo3::prelude::*;
use serde_json::value::RawValue;

use crate::interpreter::error::Exception;
use crate::interpreter::process::{interpreter_arguments, launcher};
use crate::interpreter::signals::{interrupt, interrupted};

/// Runs the command `b2b` with arguments, or the worker loop if this process was started as a worker, and ends the
/// process.
///
/// `file` is the path of this extension module. Engine and weather files installed by pip next to the package are used.
#[pyfunction]
#[pyo3(signature = (file, *arguments))]
pub fn run_command(py: Python<'_>, file: &str, arguments: Vec<OsString>) -> PyResult<()> {
    let interpreter: OsString = py.import("sys")?.getattr("executable")?.extract()?;
    if let Some(site_packages) = Path::new(file).parent().and_then(Path::parent) {
        use_packages_in(site_packages.to_owned());
    }
    let program = interpreter_arguments(file).into_iter().fold(Program::new(interpreter), Program::argument);
    let arguments = std::iter::once("b2b".into()).chain(arguments);
    let code = py.detach(|| b2b_cli::run(program, arguments));
    // Ends the process, because the interpreter's signal handlers have been replaced.
    std::process::exit(code as i32)
}

/// Carries out an action of `b2b`, with its arguments as JSON text, in a separate process, and returns its result.
/// Ctrl-C ends it.
#[pyfunction]
pub fn carry_out(py: Python<'_>, action: &str, order: &str) -> PyResult<String> {
    let launcher = launcher(py)?;
    let fault = |error: &dyn std::error::Error| Exception::Process.new_err(error.to_string());
    let order: Box<RawValue> = serde_json::from_str(order).map_err(|error| fault(&error))?;
    let silent = |command: &mut Command| {
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    };
    let end = py.detach(|| ActionProcess::start(&launcher, action, &order, silent)?.wait(interrupted));
    match end.map_err(|error| fault(&error))? {
        ActionEnd::Done(result) => Ok(result),
        ActionEnd::Failed(why) => Err(Exception::Evaluation.new_err(why)),
        ActionEnd::Interrupted => Err(interrupt()),
    }
}
