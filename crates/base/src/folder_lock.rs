//! Locks of folders, so that one process at a time writes to them.

use std::fs::{File, TryLockError};
use std::io::Result;
use std::path::Path;

/// A lock of a folder by this process. It ends on drop, and with the process. It is on the folder itself, so it can be
/// taken before the first file is written and leaves no file behind.
#[derive(Debug)]
pub struct FolderLock(#[expect(dead_code, reason = "the lock ends when it is closed")] File);

impl FolderLock {
    /// Locks an existing folder; `None` if another process, or another lock of this one, has it.
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
