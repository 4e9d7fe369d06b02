//! The lock of a run's folder: one process at a time trains in it.

use std::path::Path;

use b2b_base::folder_lock::FolderLock;

use super::run::LAST;
use crate::error::{Error, Result, at};

/// Creates the folder if there is none, and locks it. Errors if its last agent is a link to a folder of somebody else.
pub(super) fn acquire(folder: &Path) -> Result<FolderLock> {
    let last = folder.join(LAST);
    if last.is_symlink() {
        return Err(Error::Invalid(format!(
            "{} is a link; remove it, or choose another folder",
            last.display()
        )));
    }
    std::fs::create_dir_all(folder).map_err(at(folder))?;
    FolderLock::acquire(folder).map_err(at(folder))?.ok_or_else(|| {
        Error::Invalid(format!(
            "{} is in use by another run of `b2b train`; wait for its end, or choose another folder",
            folder.display()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_run_in_a_folder_is_refused_until_the_first_has_ended() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("runs/a");
        let first = acquire(&folder).unwrap();
        let said = acquire(&folder).unwrap_err().to_string();
        assert!(said.contains("runs/a is in use"), "{said}");
        drop(first);
        acquire(&folder).unwrap();
        std::os::unix::fs::symlink(root.path(), folder.join(LAST)).unwrap();
        let said = acquire(&folder).unwrap_err().to_string();
        assert!(said.contains("last is a link"), "{said}");
    }
}
