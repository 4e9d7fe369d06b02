//! The lock of a run's folder: one process at a time trains in it.

use std::path::Path;
use std::time::{Duration, Instant};

use b2b_base::folder_lock::FolderLock;

use crate::error::{Error, Result, at};

/// Name of the folder of the last agent in a run's folder.
pub const LAST: &str = "last";

/// How long to wait for another run in the folder, which may be about to end: after its experiment is killed, a
/// training still completes its update.
pub(super) const PATIENCE: Duration = Duration::from_secs(20);
/// Interval at which the lock is tried.
const POLL: Duration = Duration::from_millis(100);

/// Creates the folder if there is none, and locks it, within `patience` or until an interrupt. Errors if its last agent
/// is a link, which may lead to somebody else's folder.
pub(crate) fn acquire(folder: &Path, patience: Duration, interrupted: fn() -> bool) -> Result<FolderLock> {
    let last = folder.join(LAST);
    if last.is_symlink() {
        return Err(Error::Invalid(format!(
            "{} is a link; remove it, or choose another folder",
            last.display()
        )));
    }
    std::fs::create_dir_all(folder).map_err(at(folder))?;
    let began = Instant::now();
    loop {
        if let Some(lock) = FolderLock::acquire(folder).map_err(at(folder))? {
            return Ok(lock);
        }
        if interrupted() {
            return Err(Error::Interrupted);
        }
        if began.elapsed() >= patience {
            return Err(Error::Invalid(format!(
                "{} is in use by another run of `b2b train`; wait for its end, or choose another folder",
                folder.display()
            )));
        }
        std::thread::sleep(POLL);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_run_in_a_folder_is_refused_until_the_first_has_ended() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("runs/a");
        let first = acquire(&folder, Duration::ZERO, || false).unwrap();
        let said = acquire(&folder, Duration::ZERO, || false).unwrap_err().to_string();
        assert!(said.contains("runs/a is in use"), "{said}");
        let said = acquire(&folder, PATIENCE, || true).unwrap_err().to_string();
        assert!(said.contains("interrupted"), "{said}");
        let ending = std::thread::spawn(move || {
            std::thread::sleep(3 * POLL);
            drop(first);
        });
        drop(acquire(&folder, PATIENCE, || false).unwrap());
        ending.join().unwrap();
        acquire(&folder, Duration::ZERO, || false).unwrap();
        std::os::unix::fs::symlink(root.path(), folder.join(LAST)).unwrap();
        let said = acquire(&folder, Duration::ZERO, || false).unwrap_err().to_string();
        assert!(said.contains("last is a link"), "{said}");
    }
}
