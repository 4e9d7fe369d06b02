//! The command `b2b`, in an interpreter that has loaded only this extension module.

use std::ffi::OsString;
use std::path::Path;

use b2b_cli::Program;
use b2b_energyplus::install::use_packages_in;
use pyo3::prelude::*;

use crate::interpreter::process::interpreter_arguments;

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

/// Returns the arguments with which an interpreter runs the command `b2b` from this extension module in `file`, without
/// code of the current folder. The command's own arguments follow.
#[pyfunction]
pub fn command_arguments(file: &str) -> [&str; 5] {
    interpreter_arguments(file)
}
