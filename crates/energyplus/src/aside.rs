//! Atomic writing of files: a file appears complete or not at all.

use std::io::{Result, Write as _};
use std::path::Path;

use tempfile::NamedTempFile;

/// Writes a file next to its place, to be moved there by [`put`].
///
/// # Errors
/// Those of the operating system.
pub fn write(path: &Path, bytes: &[u8]) -> Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".aside-");
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
