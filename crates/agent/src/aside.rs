//! Atomic writing of files: a file appears complete or not at all.

use std::io::Write as _;
use std::path::Path;

use tempfile::NamedTempFile;

use crate::Result;
use crate::error::at;

/// Writes a file next to its place, to be moved there by [`put`].
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".aside-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // As of a new file; less the user's mask.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder).map_err(at(path))?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(at(path))?;
    Ok(file)
}

/// Moves a file to its place, replacing an existing one.
pub(crate) fn put(file: NamedTempFile, path: &Path) -> Result<()> {
    file.persist(path).map(|_| ()).map_err(|error| at(path)(error.error))
}

/// Writes a file aside and moves it to its place.
///
/// # Errors
/// [`Error::Io`](crate::Error::Io); what was there before is still there then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    put(write(path, bytes)?, path)
}
