//! The loaded shared library of EnergyPlus.

use std::ffi::CStr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::api::Api;
use crate::{Error, Result};

/// The shared library of EnergyPlus, loaded for the rest of the process. Clones are cheap.
#[derive(Clone)]
pub struct Library {
    pub(crate) api: Arc<Api>,
    path: PathBuf,
}

impl std::fmt::Debug for Library {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Library({})", self.path.display())
    }
}

impl Library {
    /// Loads `libenergyplusapi` from a file.
    ///
    /// # Errors
    /// [`Error::Library`] if the file is missing, is not a library, or lacks a function of the C API.
    pub fn load(path: &Path) -> Result<Self> {
        let api =
            Api::load(path).map_err(|e| Error::Library { path: path.to_owned(), why: e.to_string() })?;
        Ok(Self { api: Arc::new(api), path: path.to_owned() })
    }

    /// Path of the library file.
    pub fn path(&self) -> &Path {
        &self.path
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

/// Locks EnergyPlus for the current thread. The library has global state: two threads in it at once give silently wrong
/// numbers, while interleaved calls are exact.
pub(crate) fn lock() -> MutexGuard<'static, ()> {
    static LOCK: Mutex<()> = Mutex::new(());
    LOCK.lock().unwrap_or_else(PoisonError::into_inner)
}
