//! Files that appear complete or not at all.

use std::io::Write as _;
use std::path::Path;

use crate::error::{Error, Result, at};

/// Writes a file aside and moves it into place.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(".aside-").tempfile_in(folder).map_err(at(path))?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(at(path))?;
    file.persist(path).map(|_| ()).map_err(|error| Error::Io { path: path.to_owned(), source: error.error })
}
