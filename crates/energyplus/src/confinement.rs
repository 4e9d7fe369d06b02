//! Confinement of a process to what a simulation needs, on kernels with Landlock (Linux 5.13; network from 6.7 on).
//!
//! Models are untrusted data, read by an engine of native code. Whatever a model makes the engine do, a confined
//! process cannot write outside its folders, run programs, or open TCP connections.

use std::cell::Cell;
use std::fmt;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};

use crate::install::cache_dir;

/// The device that programs write to when their output is discarded.
const NULL_DEVICE: &str = "/dev/null";

thread_local! {
    static CONFINED: Cell<bool> = const { Cell::new(false) };
}

/// How far a process is confined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confinement {
    /// Fully: files, programs and network.
    Full,
    /// Partially, on an older kernel.
    Partial,
    /// Not at all: the kernel has no Landlock, or it is switched off.
    None,
}

impl Confinement {
    /// Returns what the confinement of a program lacked, as a clause after its name; empty if it was full.
    pub fn clause(self) -> &'static str {
        match self {
            Self::Full => "",
            Self::Partial => ", which could connect to a network (Linux before 6.7)",
            Self::None => ", which was not confined: this system has no Landlock",
        }
    }

    /// Returns how far processes can be confined on this machine.
    pub fn available() -> Self {
        std::thread::spawn(confine).join().unwrap_or(Self::None)
    }
}

impl fmt::Display for Confinement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "may write to the temporary folder and the cache, run no programs, and not connect",
            Self::Partial => {
                "may write to the temporary folder and the cache, and run no programs (Linux before 6.7)"
            }
            Self::None => "not confined: this system has no Landlock",
        })
    }
}

/// Irreversibly confines this thread, and all threads and processes that it starts later: they can write only in the
/// temporary folder and the cache of this package, run no programs and not connect.
pub fn confine() -> Confinement {
    CONFINED.set(true);
    confine_to(None)
}

/// Like [`confine`], but also allows writing in `folder`.
pub fn confine_with(folder: &Path) -> Confinement {
    CONFINED.set(true);
    confine_to(Some(folder))
}

/// Runs a function in a confined thread, which may also write to `folder`, and returns its result. Starts a thread
/// unless this one is already confined.
pub(crate) fn confined<T: Send>(folder: Option<&Path>, function: impl FnOnce() -> T + Send) -> T {
    if CONFINED.get() {
        return function();
    }
    in_thread(|| confine_to(folder), function).1
}

/// Runs a function in a confined thread, which may write only to `folder` and run only these `programs`, and returns
/// how far it was confined and its result.
pub(crate) fn confined_to_program<T: Send>(
    folder: &Path,
    programs: &[PathBuf],
    function: impl FnOnce() -> T + Send,
) -> (Confinement, T) {
    let writable = [folder.to_owned(), PathBuf::from(NULL_DEVICE)];
    in_thread(|| restrict(writable.into_iter(), None, programs), function)
}

/// Runs a function in a thread of its own that is confined first. Returns how far it was confined, and the result.
fn in_thread<T: Send>(
    confine: impl FnOnce() -> Confinement + Send,
    function: impl FnOnce() -> T + Send,
) -> (Confinement, T) {
    let confined = || (confine(), function());
    std::thread::scope(|scope| scope.spawn(confined).join()).unwrap_or_else(|panic| resume_unwind(panic))
}

fn confine_to(folder: Option<&Path>) -> Confinement {
    let (temporary, devices) = (std::env::temp_dir(), PathBuf::from(NULL_DEVICE));
    let parent = temporary.parent().map(Path::to_owned);
    let folders = cache_dir().ok().into_iter().chain(folder.map(Path::to_owned));
    restrict([temporary, devices].into_iter().chain(folders), parent, &[])
}

/// Restricts this thread to writing in the `writable` folders, removing empty folders in `emptied` (a worker whose
/// owner is gone removes its own temporary folder) and running `programs`.
fn restrict(
    writable: impl Iterator<Item = PathBuf>,
    emptied: Option<PathBuf>,
    programs: &[PathBuf],
) -> Confinement {
    use landlock::{
        ABI, Access, AccessFs, AccessNet, Ruleset, RulesetAttr, RulesetCreatedAttr, RulesetError,
        RulesetStatus, path_beneath_rules,
    };
    let writing = AccessFs::from_write(ABI::V4);
    let restrict = || -> Result<RulesetStatus, RulesetError> {
        let ruleset = Ruleset::default()
            .handle_access(writing | AccessFs::Execute)?
            .handle_access(AccessNet::from_all(ABI::V4))?
            .create()?
            .add_rules(path_beneath_rules(writable, writing))?
            .add_rules(path_beneath_rules(emptied, AccessFs::RemoveDir))?
            .add_rules(path_beneath_rules(programs, AccessFs::Execute))?;
        Ok(ruleset.restrict_self()?.ruleset)
    };
    match restrict() {
        Ok(RulesetStatus::FullyEnforced) => Confinement::Full,
        Ok(RulesetStatus::PartiallyEnforced) => Confinement::Partial,
        Ok(RulesetStatus::NotEnforced) | Err(_) => Confinement::None,
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind::PermissionDenied;
    use std::process::Command;

    use super::*;

    #[test]
    fn a_confined_thread_writes_only_to_its_folders_and_cannot_run_programs_or_connect() {
        let root = tempfile::tempdir().unwrap();
        let [inside, outside] = ["inside", "outside"].map(|name| {
            let path = root.path().join(name);
            std::fs::create_dir(&path).unwrap();
            std::fs::create_dir(path.join("empty")).unwrap();
            std::fs::write(path.join("there"), "before").unwrap();
            path
        });
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let confined = std::thread::spawn(move || {
            let confinement =
                restrict(std::iter::once(inside.clone()), inside.parent().map(Path::to_owned), &[]);
            if confinement == Confinement::None {
                return confinement;
            }
            std::fs::write(inside.join("new"), "text").unwrap();
            assert_eq!(std::fs::read_to_string(outside.join("there")).unwrap(), "before");
            let empty = outside.join("empty");
            std::fs::remove_dir(empty).unwrap();
            let denied = |result: std::io::Result<()>| result.unwrap_err().kind() == PermissionDenied;
            assert!(denied(std::fs::write(outside.join("new"), "text")));
            assert!(denied(std::fs::write(outside.join("there"), "after")));
            assert!(denied(std::fs::remove_file(outside.join("there"))));
            assert!(denied(Command::new("/bin/true").status().map(drop)));
            if confinement == Confinement::Full {
                assert!(denied(std::net::TcpStream::connect(address).map(drop)));
            }
            confinement
        });
        let confinement = confined.join().unwrap();
        // Other threads are free.
        std::fs::write(root.path().join("outside/new"), "text").unwrap();
        eprintln!("Landlock: {confinement:?}");
    }
}
