//! Launching of worker processes.

use std::ffi::OsString;
use std::fs::File;
use std::io;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::worker::entry::FLAG;

/// A program that calls [`run_if_worker`](crate::run_if_worker), and the arguments that precede the worker's own.
#[derive(Clone, Debug)]
pub struct Launcher {
    program: PathBuf,
    arguments: Vec<OsString>,
}

impl Launcher {
    /// Creates a launcher of a program.
    pub fn new(program: impl Into<PathBuf>) -> Self {
        Self { program: program.into(), arguments: Vec::new() }
    }

    /// Creates a launcher of this program.
    ///
    /// # Errors
    /// If the path of this program cannot be determined.
    pub fn this_program() -> io::Result<Self> {
        Ok(Self::new(std::env::current_exe()?))
    }

    /// Adds an argument before the worker's own, for example for an interpreter.
    #[must_use]
    pub fn argument(mut self, argument: impl Into<OsString>) -> Self {
        self.arguments.push(argument.into());
        self
    }

    /// Starts a worker with an order; for an episode, `input` is the shared memory. Its temporary files go to `folder`.
    /// It has its own process group, so that signals from a terminal or a job scheduler reach only the owner, which
    /// ends its workers.
    pub(crate) fn start(&self, input: Stdio, order: &Path, folder: &Path, log: File) -> io::Result<Child> {
        self.command(order, folder)
            .env("GLIBC_TUNABLES", tunables())
            .stdin(input)
            .stdout(Stdio::null())
            .stderr(Stdio::from(log))
            .spawn()
    }

    /// Returns a command that carries out an order, with temporary files in `folder`.
    pub(crate) fn command(&self, order: &Path, folder: &Path) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.arguments).arg(FLAG).arg(std::process::id().to_string()).arg(order);
        command.env("TMPDIR", folder).process_group(0);
        command
    }

    /// The program.
    pub fn program(&self) -> &Path {
        &self.program
    }
}

/// The engine touches about 6 MB of small objects per step. Large pages save a fifth of the time where many processes
/// share a processor (compare `b2b bench vector` without this line).
const LARGE_PAGES: &str = "glibc.malloc.hugetlb=1";

/// Returns this process's settings of the C library, with large heap pages turned on.
fn tunables() -> OsString {
    let mut tunables = std::env::var_os("GLIBC_TUNABLES").unwrap_or_default();
    if !tunables.is_empty() {
        tunables.push(":");
    }
    tunables.push(LARGE_PAGES);
    tunables
}
