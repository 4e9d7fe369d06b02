//! Temporary folders and files that are removed with their owner: on drop or, if the owner was killed, when another is
//! created after an hour.
//!
//! A name identifies its owner. In `b2b-pool-4242.891.5f0c9a1e-x7Pq2a` it is process 4242, started at clock tick 891,
//! in the process numbering `5f0c9a1e`. Containers that share a folder have separate numberings and do not touch each
//! other's folders.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use tempfile::TempDir;

use crate::digest::sha256;

/// Free space that a run needs in the temporary folder, bytes: model, table of sizes and messages. A medium office uses
/// a tenth of it.
const NEEDED: u64 = 8_000_000;
/// Age at which the folder of an ended owner is removed: forks may still use a newer one.
const GRACE: Duration = Duration::from_secs(3600);

/// A temporary folder that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot use the temporary folder {path}: {why}. Free some space in it, or set TMPDIR to another folder"
)]
pub struct TemporaryFolderError {
    /// The folder.
    pub path: PathBuf,
    /// Reason.
    pub why: String,
}

/// Creates a temporary folder for the files of EnergyPlus, readable only by this user, and removes folders of killed
/// processes that have not changed for an hour.
///
/// # Errors
/// [`TemporaryFolderError`] if it cannot be created or has too little space for a run.
pub fn temporary_folder(prefix: &str) -> Result<TempDir, TemporaryFolderError> {
    let parent = std::env::temp_dir();
    let cannot = |why: String| TemporaryFolderError { path: parent.clone(), why };
    {
        let found = rustix::fs::statvfs(&parent).map_err(|error| cannot(error.to_string()))?;
        check_space(found.f_bavail.saturating_mul(found.f_frsize)).map_err(cannot)?;
    }
    folder_in(&parent, prefix).map_err(|error| cannot(error.to_string()))
}

/// Like [`temporary_folder`], in any folder and without a check of its space.
///
/// # Errors
/// Errors of the operating system.
pub fn folder_in(parent: &Path, prefix: &str) -> std::io::Result<TempDir> {
    sweep(parent, prefix);
    let mut builder = tempfile::Builder::new();
    let prefix = owned(prefix);
    builder.prefix(&prefix);
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o700));
    }
    let folder = builder.tempdir_in(parent)?;
    let mut created = CREATED.lock().unwrap_or_else(PoisonError::into_inner);
    created.retain(|path| path.exists());
    created.push(std::path::absolute(folder.path())?);
    Ok(folder)
}

/// Folders of this process that still existed when it created the last one.
static CREATED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes all temporary folders of this process, which is about to end without dropping them.
pub fn remove_all() {
    let mut created = CREATED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in created.drain(..) {
        let _ = std::fs::remove_dir_all(path);
    }
}

/// Returns a name with this prefix that identifies this process as the owner.
pub(crate) fn owned(prefix: &str) -> String {
    let process = std::process::id();
    match started(process).zip(numbering()) {
        Some((start, numbering)) => format!("{prefix}{process}.{start}.{numbering}-"),
        None => prefix.to_owned(),
    }
}

/// Removes folders and files with a prefix whose owner has ended and that have not changed for an hour. Keeps what it
/// cannot remove, such as another user's files, and what comes from another container or from before the last boot,
/// because its owner is unknown here.
pub(crate) fn sweep(parent: &Path, prefix: &str) {
    let (Some(here), Ok(entries)) = (numbering(), std::fs::read_dir(parent)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let owner = name.to_str().and_then(|name| owner(name.strip_prefix(prefix)?, &here));
        if owner.is_some_and(|(process, start)| started(process) != Some(start)) && is_old(&entry) {
            let path = entry.path();
            let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
        }
    }
}

/// Reads process and start from a name without its prefix. `None` if its process numbering is not `here`.
fn owner(name: &str, here: &str) -> Option<(u32, u64)> {
    let (owner, _) = name.split_once('-')?;
    let (process, rest) = owner.split_once('.')?;
    let (start, numbering) = rest.split_once('.')?;
    (numbering == here).then_some((process.parse().ok()?, start.parse().ok()?))
}

/// Returns an identifier of the process numbering: a digest of the machine's boot id and the PID namespace. `None`
/// without `/proc`.
fn numbering() -> Option<String> {
    let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let namespace = std::fs::read_link("/proc/self/ns/pid").ok()?;
    let mut digest = sha256(format!("{boot}{}", namespace.display()));
    digest.truncate(8);
    Some(digest)
}

fn is_old(entry: &std::fs::DirEntry) -> bool {
    let modified = entry.metadata().and_then(|metadata| metadata.modified());
    let age = modified.map(|modified| SystemTime::now().duration_since(modified).unwrap_or_default());
    age.is_ok_and(|age| age > GRACE)
}

/// Returns when a process started, in clock ticks since the boot. `None` if there is no such process, or no `/proc`.
fn started(process: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the program, in parentheses, may contain any character.
    let (_, fields) = stat.rsplit_once(')')?;
    fields.split_whitespace().nth(19)?.parse().ok()
}

fn check_space(free: u64) -> Result<(), String> {
    if free >= NEEDED {
        return Ok(());
    }
    let [free, needed] = [free, NEEDED].map(|bytes| bytes as f64 / 1e6);
    Err(format!("it has {free:.1} MB of free space; a run needs {needed:.0} MB"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_temporary_folder_is_private_and_needs_space() {
        use std::os::unix::fs::PermissionsExt;
        let folder = temporary_folder("b2b-test-").unwrap();
        assert_eq!(folder.path().metadata().unwrap().permissions().mode() & 0o777, 0o700);
        check_space(NEEDED).unwrap();
        let said = check_space(900_000).unwrap_err();
        assert!(said.contains("0.9 MB") && said.contains("8 MB"), "{said}");
    }

    #[test]
    fn folders_of_dead_owners_are_removed_after_an_hour_and_no_others() {
        let root = tempfile::tempdir().unwrap();
        let here = std::process::id();
        let (start, number) = (started(here).unwrap(), numbering().unwrap());
        let old = SystemTime::now() - 2 * GRACE;
        let make = |name: &str, modified: SystemTime| {
            let path = root.path().join(name);
            std::fs::create_dir(&path).unwrap();
            std::fs::write(path.join("eplusout.err"), "").unwrap();
            std::fs::File::open(&path).unwrap().set_modified(modified).unwrap();
        };
        let mine = format!("b2b-{here}.{start}.{number}-mine");
        let fresh = format!("b2b-4194305.7.{number}-fresh");
        let other = format!("b2b-pool-4194305.7.{number}-other");
        make(&mine, old);
        make(&format!("b2b-{here}.{}.{number}-reused", start + 1), old);
        make(&format!("b2b-4194305.7.{number}-gone"), old);
        make(&fresh, SystemTime::now());
        make(&other, old);
        make("b2b-4194305.7.00000000-container", old);
        make("b2b-4194305.7-earlier", old);
        make("b2b-notes", old);
        let file = root.path().join(format!("b2b-4194305.7.{number}-file"));
        std::fs::write(&file, "").unwrap();
        std::fs::File::open(&file).unwrap().set_modified(old).unwrap();
        let made = folder_in(root.path(), "b2b-").unwrap();
        let mut left: Vec<_> = std::fs::read_dir(root.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.retain(|name| name.as_str() != made.path().file_name().unwrap());
        left.sort();
        let container = "b2b-4194305.7.00000000-container";
        let mut expected = [&fresh, &mine, &other, container, "b2b-4194305.7-earlier", "b2b-notes"];
        expected.sort_unstable();
        assert_eq!(left, expected);
    }
}
