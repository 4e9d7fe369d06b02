//! The loaded shared library of EnergyPlus.

#![allow(unsafe_code, reason = "the C API of EnergyPlus")]

use std::cell::RefCell;
use std::ffi::CStr;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::api::Api;
use crate::install::ENGINE_VERSION;
use crate::{Error, Host, Result};

/// The shared library of EnergyPlus, loaded for the rest of the process. Clones are cheap.
#[derive(Clone)]
pub struct Library {
    pub(crate) api: Arc<Api>,
    path: PathBuf,
    /// Converts models and runs them to their end; this process does if `None`.
    pub(crate) host: Option<Arc<dyn Host>>,
}

/// Environment variables by which EnergyPlus simulates something else than its model says: other days, other radiation, or
/// other shading.
const CHANGE_RESULTS: [&str; 14] = [
    "CIFORCETIMESTEP",
    "CreateMinimalSurfaceVariables",
    "DDONLY",
    "DISABLEGLHECACHING",
    "FULLANNUALRUN",
    "IgnoreBeamRadiation",
    "IgnoreDiffuseRadiation",
    "IgnoreSolarRadiation",
    "MINREPORTFREQUENCY",
    "MinimalShadowing",
    "REVERSEDD",
    "ReportDuringWarmup",
    "SlaterBarsky",
    "SutherlandHodgman",
];

impl std::fmt::Debug for Library {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Library({})", self.path.display())
    }
}

impl Library {
    /// Loads `libenergyplusapi` from a file.
    ///
    /// # Errors
    /// [`Error::Library`] if the file is missing, is not a library, or lacks a function of the C API;
    /// [`Error::EnvironmentVariable`].
    pub fn load(path: &Path) -> Result<Self> {
        let is_set = |name: &&str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        if let Some(name) = CHANGE_RESULTS.into_iter().find(is_set) {
            return Err(Error::EnvironmentVariable { name });
        }
        let api =
            Api::load(path).map_err(|e| Error::Library { path: path.to_owned(), why: e.to_string() })?;
        Ok(Self { api: Arc::new(api), path: path.to_owned(), host: None })
    }

    /// Lets other processes convert models and run them to their end. A [`Simulation`](crate::Simulation) that is
    /// advanced step by step stays in this process.
    #[must_use]
    pub fn hosted_by(self, host: Arc<dyn Host>) -> Self {
        Self { host: Some(host), ..self }
    }

    /// Returns whether other processes run models to their end, so that several may run at a time.
    pub fn is_hosted(&self) -> bool {
        self.host.is_some()
    }

    /// Returns the path of the library file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Checks that the library is of [`ENGINE_VERSION`], which results state.
    ///
    /// # Errors
    /// [`Error::OtherVersion`].
    pub fn check_version(&self) -> Result<()> {
        let version = self.version();
        match version.starts_with(ENGINE_VERSION) {
            true => Ok(()),
            false => Err(Error::OtherVersion { path: self.path.clone(), version, expected: ENGINE_VERSION }),
        }
    }

    /// Returns the version of EnergyPlus, for example `25.2.0-cf7368216c`.
    pub fn version(&self) -> String {
        // SAFETY: the function takes nothing and returns a static C string.
        let text = unsafe { CStr::from_ptr((self.api.energyPlusVersion)()) };
        let text = text.to_string_lossy();
        let version = text.rsplit("Version").next().unwrap_or(&text);
        version.trim_matches([' ', ',']).to_owned()
    }
}

/// Keeps other threads of the process out of EnergyPlus while it lives; see [`exclusive`]. A thread releases the lock
/// when its last guard is dropped, in any order.
#[must_use]
#[derive(Debug)]
pub struct Exclusive {
    /// Not `Send`, like the guard of the lock.
    _of_thread: PhantomData<MutexGuard<'static, ()>>,
}

/// The lock of a thread.
struct Held {
    /// Number of [`Exclusive`] guards held by the thread.
    depth: usize,
    /// The lock, while there are any.
    lock: Option<MutexGuard<'static, ()>>,
}

thread_local! {
    static HELD: RefCell<Held> = const { RefCell::new(Held { depth: 0, lock: None }) };
}

/// Locks EnergyPlus for the current thread, which may have the lock already. The library has global state: two threads
/// in it at once give silently wrong numbers, while interleaved calls are exact, with one exception: a run that starts
/// or ends while another is in the first steps of its warm-up can change the last digits of the results of either.
/// Where other threads may do so, hold the lock from the start of a run to the end of its warm-up.
pub fn exclusive() -> Exclusive {
    static LOCK: Mutex<()> = Mutex::new(());
    HELD.with_borrow_mut(|held| {
        if held.depth == 0 {
            held.lock = Some(LOCK.lock().unwrap_or_else(PoisonError::into_inner));
        }
        held.depth += 1;
    });
    Exclusive { _of_thread: PhantomData }
}

impl Drop for Exclusive {
    fn drop(&mut self) {
        // At the end of a thread, the lock may have been released already.
        let _ = HELD.try_with(|held| {
            let mut held = held.borrow_mut();
            held.depth -= 1;
            if held.depth == 0 {
                held.lock = None;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_lock_is_reentrant_and_excludes_other_threads() {
        // For either order of drops.
        for is_outer_first in [false, true] {
            let (sender, receiver) = mpsc::channel();
            let mut both = [exclusive(), exclusive()];
            if is_outer_first {
                both.reverse();
            }
            let [last, first] = both;
            drop(first);
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    let _exclusive = exclusive();
                    sender.send(())
                });
                let early = receiver.recv_timeout(Duration::from_millis(50));
                assert!(early.is_err(), "another thread has entered");
                drop(last);
                receiver.recv().unwrap();
            });
        }
    }
}
