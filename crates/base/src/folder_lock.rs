//! Locks on folders, so that one process at a time writes to them.

use std::fs::{File, TryLockError};
use std::io::Result;
use std::path::Path;

/// A lock on a folder, held by this process until it is dropped or the process ends. It is on the folder itself, so it
/// can be taken before the first file is written and leaves no file behind.
#[derive(Debug)]
pub struct FolderLock(#[expect(dead_code, reason = "closing the file releases the lock")] File);

impl FolderLock {
    /// Locks an existing folder; `None` if it is already locked, by another process or by this one.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn acquire(folder: &Path) -> Result<Option<Self>> {
        let file = File::open(folder)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self(file))),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_lock_at_a_time_and_nothing_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let lock = FolderLock::acquire(folder.path()).unwrap();
        assert!(lock.is_some());
        assert!(FolderLock::acquire(folder.path()).unwrap().is_none());
        drop(lock);
        assert!(FolderLock::acquire(folder.path()).unwrap().is_some());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
