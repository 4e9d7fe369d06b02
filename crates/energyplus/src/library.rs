//! The engine's shared library, loaded.

use std::ffi::CStr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::api::Api;
use crate::{Error, Result};

/// The engine's shared library, loaded for the rest of the process. Clones are cheap.
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
    /// [`Error::Library`] when the file is missing, is no library, or lacks a function of the C API.
    pub fn load(path: &Path) -> Result<Self> {
        let api =
            Api::load(path).map_err(|e| Error::Library { path: path.to_owned(), why: e.to_string() })?;
        Ok(Self { api: Arc::new(api), path: path.to_owned() })
    }

    /// The file it was loaded from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The engine's version as it says it, for example `25.2.0-cf7368216c`.
    pub fn version(&self) -> String {
        // SAFETY: the function takes nothing and returns a static C string.
        let text = unsafe { CStr::from_ptr((self.api.energyPlusVersion)()) };
        let text = text.to_string_lossy();
        let version = text.rsplit("Version").next().unwrap_or(&text);
        version.trim_matches([' ', ',']).to_owned()
    }
}

/// The right to run the engine's code. The library has global state: two threads in it at once give silently
/// wrong numbers, while taking turns gives the right bits.
pub(crate) fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}
