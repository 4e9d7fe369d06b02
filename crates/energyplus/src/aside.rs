//! Atomic writing of files: a file appears complete or not at all.

use std::collections::HashSet;
use std::io::{Result, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::scratch::{owned, sweep};

/// Prefix of the names of files before they are moved.
const PREFIX: &str = ".aside-";

/// Writes a file next to its place, to be moved there by [`put`].
///
/// # Errors
/// Those of the operating system.
pub fn write(path: &Path, bytes: &[u8]) -> Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    sweep_once(folder);
    let mut builder = tempfile::Builder::new();
    let prefix = owned(PREFIX);
    builder.prefix(&prefix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // As of a new file; less the user's mask.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// Removes what killed processes left in a folder, once per process, because a folder may have thousands of files.
fn sweep_once(folder: &Path) {
    static SWEPT: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if swept.insert(folder.to_owned()) {
        sweep(folder, PREFIX);
    }
}

/// Moves a file to its place, replacing an existing one.
///
/// # Errors
/// Those of the operating system.
pub fn put(file: NamedTempFile, path: &Path) -> Result<()> {
    file.persist(path).map(|_| ()).map_err(|error| error.error)
}

/// Writes a file aside and moves it to its place.
///
/// # Errors
/// Those of the operating system; what was there before is still there then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    put(write(path, bytes)?, path)
}
