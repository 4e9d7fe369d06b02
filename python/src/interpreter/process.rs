//! This interpreter as a process: its launch as a worker, and the ownership of environments across forks.

use std::sync::{Mutex, MutexGuard, PoisonError};

use b2b_workers::Launcher;
use pyo3::prelude::*;

use crate::interpreter::error::Exception;

/// The code that the interpreter runs as a worker or as the command `b2b`. It loads this extension module from its file
/// and nothing else, so that the process starts in tens of milliseconds and has one thread.
const BOOTSTRAP: &str = "\
import sys
from importlib.machinery import ExtensionFileLoader, ModuleSpec
import _imp
spec = ModuleSpec('building2building._core', ExtensionFileLoader('building2building._core', sys.argv[1]), \
origin=sys.argv[1])
module = _imp.create_dynamic(spec)
_imp.exec_dynamic(module)
module.run_command(*sys.argv[1:])";

/// Returns the arguments with which an interpreter loads this extension module from its file. A worker's or a command's
/// own arguments follow.
pub fn interpreter_arguments(file: &str) -> [&str; 5] {
    ["-I", "-S", "-c", BOOTSTRAP, file]
}

/// Returns a launcher of this interpreter as a worker.
pub fn launcher(py: Python<'_>) -> PyResult<Launcher> {
    let text = |module: &str, name: &str| -> PyResult<String> {
        let value = py.import(module)?.getattr(name)?.extract::<Option<String>>()?;
        value.filter(|value| !value.is_empty()).ok_or_else(|| {
            Exception::Process
                .new_err(format!("`{module}.{name}` is empty, but worker processes are started from it"))
        })
    };
    let file = text("building2building._core", "__file__")?;
    let launcher = Launcher::new(text("sys", "executable")?);
    Ok(interpreter_arguments(&file).into_iter().fold(launcher, Launcher::argument))
}

/// Locks a mutex, even if a thread panicked while holding it.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The process that owns a resource; a fork of it must not use the resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnerProcess(u32);

impl OwnerProcess {
    /// Returns this process.
    pub fn this() -> Self {
        Self(std::process::id())
    }

    /// Returns whether it is this process.
    pub fn is_current(self) -> bool {
        self == Self::this()
    }

    /// Runs `work` on the state with the GIL released. It must be released before the state is locked, because the
    /// thread that holds the state takes the GIL from time to time to handle signals.
    pub fn with<S: Send, T: Send>(
        self,
        py: Python<'_>,
        state: &Mutex<S>,
        work: impl FnOnce(&mut S) -> PyResult<T> + Send,
    ) -> PyResult<T> {
        self.check()?;
        py.detach(|| work(&mut locked(state)))
    }

    /// Errors if it is not this process.
    pub fn check(self) -> PyResult<()> {
        if self.is_current() {
            return Ok(());
        }
        Err(Exception::Process.new_err(format!(
            "this environment belongs to process {}; create another one in its fork {}",
            self.0,
            std::process::id()
        )))
    }
}
