//! How processes are started from Python, and how waiting for them ends with Ctrl-C.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::Mutex;

use b2b_energyplus::install::Progress;
use b2b_env::vector::{Launcher, PoolOptions};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::catalog::{self, locked};
use crate::error::raise;

/// Memory that templates of one environment's pool may hold when no episode descends from them, bytes.
pub const TEMPLATES: u64 = 1 << 30;

/// What the interpreter runs as a worker: this extension module from its file and nothing else, so that it starts in
/// tens of milliseconds and has one thread.
const BOOTSTRAP: &str = "\
import sys
from importlib.machinery import ExtensionFileLoader, ModuleSpec
import _imp
spec = ModuleSpec('building2building._core', ExtensionFileLoader('building2building._core', sys.argv[1]), \
origin=sys.argv[1])
module = _imp.create_dynamic(spec)
_imp.exec_dynamic(module)
module.run_if_worker()";

thread_local! {
    /// What a signal handler raised while this thread waited.
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
}

/// Lets Python handle signals; whether a handler raised.
pub fn interrupted() -> bool {
    let Err(error) = Python::attach(|py| py.check_signals()) else { return false };
    RAISED.set(Some(error));
    true
}

/// Says nothing, and ends a download with Ctrl-C.
pub struct Signals;

impl Progress for Signals {
    fn advance(&mut self, _: u64) -> ControlFlow<()> {
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// What the signal handler raised.
pub fn interrupt() -> PyErr {
    RAISED.take().unwrap_or_else(|| PyKeyboardInterrupt::new_err(()))
}

/// Options of a pool whose processes are this interpreter started once more.
pub fn options(py: Python<'_>) -> PyResult<PoolOptions> {
    let text = |module: &str, name: &str| -> PyResult<String> {
        let value = py.import(module)?.getattr(name)?.extract::<Option<String>>()?;
        value.filter(|value| !value.is_empty()).ok_or_else(|| {
            raise(
                "ProcessError",
                format!("`{module}.{name}` is empty: it must name what workers are started from"),
            )
        })
    };
    let launcher = ["-I", "-S", "-c", BOOTSTRAP, &text("building2building._core", "__file__")?]
        .into_iter()
        .fold(Launcher::new(text("sys", "executable")?), |launcher, argument| launcher.argument(argument));
    let library = py.detach(catalog::library)?;
    Ok(PoolOptions { interrupted, template_memory: TEMPLATES, ..PoolOptions::new(launcher, library) })
}

/// The process that something belongs to: a copy of it in a forked process must leave it alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner(u32);

impl Owner {
    /// This process.
    pub fn this() -> Self {
        Self(std::process::id())
    }

    /// Whether it is this process.
    pub fn is_here(self) -> bool {
        self == Self::this()
    }

    /// Works on what belongs to this process without holding up other Python threads. Whoever waits for the state must
    /// not hold the interpreter: who has the state asks for it now and then, to see to signals.
    pub fn with<S: Send, T: Send>(
        self,
        py: Python<'_>,
        state: &Mutex<S>,
        work: impl FnOnce(&mut S) -> PyResult<T> + Send,
    ) -> PyResult<T> {
        self.check()?;
        py.detach(|| work(&mut locked(state)))
    }

    /// An exception that says so if it is not.
    pub fn check(self) -> PyResult<()> {
        if self.is_here() {
            return Ok(());
        }
        Err(raise(
            "ProcessError",
            format!(
                "this environment belongs to process {}, and this is its fork {}: make one of its own here",
                self.0,
                std::process::id()
            ),
        ))
    }
}
