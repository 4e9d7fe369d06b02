//! Atomic writing of files: a file appears complete or not at all. No file is written through a link.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{Result, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::scratch::{owned, sweep};

/// Prefix of the names of files before they are moved.
const PREFIX: &str = ".aside-";

/// Writes a file next to its destination under a random name, to be moved there by [`put`].
///
/// # Errors
/// Errors of the operating system.
pub fn write(path: &Path, bytes: &[u8]) -> Result<NamedTempFile> {
    write_by(path, |file| file.write_all(bytes))
}

/// Like [`write()`], with a function that writes the content.
fn write_by(path: &Path, content: impl FnOnce(&mut File) -> Result<()>) -> Result<NamedTempFile> {
    let folder = folder_of(path);
    sweep_once(folder);
    let mut builder = tempfile::Builder::new();
    let prefix = owned(PREFIX);
    builder.prefix(&prefix);
    {
        use std::os::unix::fs::PermissionsExt as _;
        // The permissions of a new file, less the user's umask.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    content(file.as_file_mut())?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// Removes files that killed processes left in a folder. Runs once per process and folder, because a folder may have
/// thousands of files.
fn sweep_once(folder: &Path) {
    static SWEPT: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if swept.insert(folder.to_owned()) {
        sweep(folder, PREFIX);
    }
}

/// Moves a file into place, replacing an existing file or link.
///
/// # Errors
/// Errors of the operating system.
pub fn put(file: NamedTempFile, path: &Path) -> Result<()> {
    file.persist(path).map_err(|error| error.error)?;
    // Syncing the folder makes the rename durable, which not every file system supports.
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Writes a file aside and moves it into place.
///
/// # Errors
/// Errors of the operating system; an earlier file is then unchanged.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    put(write(path, bytes)?, path)
}

/// Like [`write_whole`], with a function that writes the content.
///
/// # Errors
/// Errors of the function and of the operating system; an earlier file is then unchanged.
pub fn write_whole_by(path: &Path, content: impl FnOnce(&mut File) -> Result<()>) -> Result<()> {
    put(write_by(path, content)?, path)
}

/// Opens a file to append to, or creates it.
///
/// # Errors
/// Errors of the operating system, also for a link.
pub fn append(path: &Path) -> Result<File> {
    let mut options = OpenOptions::new();
    options.append(true).create(true);
    {
        use std::os::unix::fs::OpenOptionsExt as _;
        options.custom_flags(libc::O_NOFOLLOW);
    }
    options.open(path)
}

/// Returns whether a path is a file that is still being written, or was left by a killed process.
pub fn is_unfinished(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_in_the_way_is_replaced_and_not_followed() {
        let root = tempfile::tempdir().unwrap();
        let (theirs, link) = (root.path().join("theirs"), root.path().join("ours"));
        std::fs::write(&theirs, "theirs").unwrap();
        std::os::unix::fs::symlink(&theirs, &link).unwrap();
        write_whole(&link, b"ours").unwrap();
        assert_eq!(std::fs::read_to_string(&theirs).unwrap(), "theirs");
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "ours");
        assert!(!link.is_symlink());
    }

    #[test]
    fn a_link_is_not_appended_to() {
        let root = tempfile::tempdir().unwrap();
        let (theirs, link) = (root.path().join("theirs"), root.path().join("ours"));
        std::fs::write(&theirs, "theirs").unwrap();
        std::os::unix::fs::symlink(&theirs, &link).unwrap();
        assert!(append(&link).is_err());
        std::fs::remove_file(&link).unwrap();
        for _ in 0..2 {
            append(&link).unwrap().write_all(b"ours").unwrap();
        }
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "oursours");
    }

    #[test]
    fn a_failed_write_leaves_only_the_earlier_file() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("file");
        write_whole(&path, b"earlier").unwrap();
        let failed = write_whole_by(&path, |file| {
            file.write_all(b"half")?;
            Err(std::io::Error::other("full"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "full");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "earlier");
        assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
