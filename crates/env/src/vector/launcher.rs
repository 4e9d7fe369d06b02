//! How the processes of a pool are started.

use std::ffi::OsString;
use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::worker::FLAG;

/// A program that calls [`run_if_worker`](super::run_if_worker), and what comes ahead of the worker's own arguments.
#[derive(Clone, Debug)]
pub struct Launcher {
    program: PathBuf,
    arguments: Vec<OsString>,
}

impl Launcher {
    /// A program.
    pub fn new(program: impl Into<PathBuf>) -> Self {
        Self { program: program.into(), arguments: Vec::new() }
    }

    /// This program.
    ///
    /// # Errors
    /// When the system does not tell which that is.
    pub fn this_program() -> io::Result<Self> {
        Ok(Self::new(std::env::current_exe()?))
    }

    /// Adds an argument ahead of the worker's own, as an interpreter needs.
    #[must_use]
    pub fn argument(mut self, argument: impl Into<OsString>) -> Self {
        self.arguments.push(argument.into());
        self
    }

    /// Starts a worker on some memory, in a seat, with an order. What it writes for a while goes to `folder`.
    pub(super) fn start(&self, memory: OwnedFd, seat: u32, order: &Path, folder: &Path) -> io::Result<Child> {
        Command::new(&self.program)
            .args(&self.arguments)
            .arg(FLAG)
            .arg(std::process::id().to_string())
            .arg(seat.to_string())
            .arg(order)
            .env("TMPDIR", folder)
            .env("GLIBC_TUNABLES", tunables())
            .stdin(Stdio::from(memory))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
    }

    /// The program.
    pub fn program(&self) -> &Path {
        &self.program
    }
}

/// The engine touches some 6 MB of small objects in a step: in large pages they cost a fifth less time where many
/// processes share a processor (`b2b bench vector` without this line shows it).
const LARGE_PAGES: &str = "glibc.malloc.hugetlb=1";

/// What this process tells its C library, and large pages for the heap.
fn tunables() -> OsString {
    let mut tunables = std::env::var_os("GLIBC_TUNABLES").unwrap_or_default();
    if !tunables.is_empty() {
        tunables.push(":");
    }
    tunables.push(LARGE_PAGES);
    tunables
}
