//! Ctrl-C and other signals while a call waits.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use b2b_energyplus::install::Progress;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

thread_local! {
    /// The exception that a signal handler raised while this thread waited.
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
}

/// Set to end the running evaluation, training or calibration: on Ctrl-C, on an exception of the policy or callback, or
/// when the callback returns `False`.
static STOP: AtomicBool = AtomicBool::new(false);

/// Returns whether the running evaluation, training or calibration must end.
pub fn stopped() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// Sets whether the running evaluation, training or calibration must end.
pub fn set_stopped(stop: bool) {
    STOP.store(stop, Ordering::Relaxed);
}

/// Lets Python handle signals and returns whether a handler raised an exception.
pub fn interrupted() -> bool {
    let Err(error) = Python::attach(|py| py.check_signals()) else { return false };
    RAISED.set(Some(error));
    true
}

/// Progress that prints nothing and lets Ctrl-C end a download.
pub struct Signals;

impl Progress for Signals {
    fn advance(&mut self, _: u64) -> ControlFlow<()> {
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Takes the exception that a signal handler raised.
pub fn take_raised() -> Option<PyErr> {
    RAISED.take()
}

/// Returns the exception that a signal handler raised, else a `KeyboardInterrupt`.
pub fn interrupt() -> PyErr {
    take_raised().unwrap_or_else(|| PyKeyboardInterrupt::new_err(()))
}
