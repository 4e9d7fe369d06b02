//! Supervision of commands that run EnergyPlus in their own process.
//!
//! A model or a weather file can make EnergyPlus crash or compute without end. Such a command therefore runs in a child
//! process: this one waits, passes requests to stop on, kills a child that does not follow them, and reports a crash with the
//! last messages of EnergyPlus. The child's temporary files are in a folder that is removed in any case.

use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use b2b_energyplus::temporary_folder;
use rustix::process::{Pid, Signal, kill_process, set_parent_process_death_signal};

use crate::{ExitCode, program};

/// Set in the environment of a supervised process.
pub const SUPERVISED: &str = "B2B_SUPERVISED";
/// Time that a process has to stop before it is killed. A second request kills it at once.
const GRACE: Duration = Duration::from_secs(10);
/// Time in which a building must be prepared.
const PREPARATION: Duration = Duration::from_secs(600);
/// Number of lines of EnergyPlus that are reported after a crash.
const LAST_LINES: usize = 5;

static CHILD: OnceLock<Pid> = OnceLock::new();
static STOPPING: AtomicBool = AtomicBool::new(false);

/// Returns whether this process is supervised. It ends with its supervisor.
pub fn is_supervised() -> bool {
    static SUPERVISED_HERE: OnceLock<bool> = OnceLock::new();
    *SUPERVISED_HERE.get_or_init(|| {
        let supervised = std::env::var_os(SUPERVISED).is_some();
        if supervised {
            // Without it, the process outlives a supervisor that is killed.
            let _ = set_parent_process_death_signal(Some(Signal::KILL));
        }
        supervised
    })
}

/// Runs this program with these arguments in a supervised process and returns its exit code. Errors if it crashes.
pub fn supervise(arguments: &[OsString]) -> Result<ExitCode> {
    ctrlc::set_handler(stop).context("cannot install the Ctrl-C handler")?;
    let folder = temporary_folder("b2b-")?;
    let mut command = program::command();
    command.args(arguments).env(SUPERVISED, "1").env("TMPDIR", folder.path());
    // It belongs to this process.
    command.env_remove(b2b_experiment::OWNER);
    let mut child = command.spawn().context("cannot start a process")?;
    CHILD.get_or_init(|| Pid::from_child(&child));
    let status = child.wait()?;
    match (status.code(), status.signal().and_then(Signal::from_named_raw)) {
        (Some(code), _) => Ok(ExitCode::of_process(code)),
        (None, Some(Signal::KILL)) if STOPPING.load(Ordering::Relaxed) => {
            eprintln!("interrupted; EnergyPlus did not stop and was killed");
            Ok(ExitCode::Interrupted)
        }
        (None, signal) => bail!(
            "EnergyPlus crashed with {}{}\nThe model or the weather file causes the crash: correct what the messages name, or \
             remove objects until it runs",
            signal.map_or_else(|| status.to_string(), name),
            last_messages(folder.path())
        ),
    }
}

/// Passes a request to stop on; kills the process if it does not follow it in time, or on a second request.
fn stop() {
    let Some(child) = CHILD.get().copied() else { std::process::exit(ExitCode::Interrupted as i32) };
    // The process may have ended just now.
    let send = move |signal| {
        let _ = kill_process(child, signal);
    };
    if STOPPING.swap(true, Ordering::Relaxed) {
        return send(Signal::KILL);
    }
    send(Signal::TERM);
    std::thread::spawn(move || {
        std::thread::sleep(GRACE);
        send(Signal::KILL);
    });
}

/// Starts the time limit of the preparation of a building, if this process is supervised: a model can keep EnergyPlus busy
/// without end, and only a process can be stopped. This one ends with an error when the time is over.
pub fn preparation_limit(building: &impl Display) -> Option<TimeLimit> {
    let building = building.to_string();
    let fail = move || {
        eprintln!(
            "error: {building} was not prepared within {} min; simplify the model: its geometry or its programs may keep \
             EnergyPlus busy without end",
            PREPARATION.as_secs() / 60
        );
        std::process::exit(ExitCode::Failure as i32);
    };
    is_supervised().then(|| TimeLimit::start(PREPARATION, fail))
}

/// A time limit, which ends when it is dropped.
pub struct TimeLimit(#[expect(dead_code, reason = "dropping it ends the wait")] Sender<()>);

impl TimeLimit {
    /// Calls a function, in another thread, when the time is over.
    fn start(limit: Duration, exceeded: impl FnOnce() + Send + 'static) -> Self {
        let (running, dropped) = channel();
        std::thread::spawn(move || {
            if dropped.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
                exceeded();
            }
        });
        Self(running)
    }
}

fn name(signal: Signal) -> String {
    let known = [
        (Signal::SEGV, "a segmentation fault (SIGSEGV)"),
        (Signal::ABORT, "an abort (SIGABRT)"),
        (Signal::BUS, "a bus error (SIGBUS)"),
        (Signal::ILL, "an illegal instruction (SIGILL)"),
        (Signal::FPE, "an arithmetic error (SIGFPE)"),
        (Signal::KILL, "SIGKILL, which the system sends when memory is exhausted"),
    ];
    let text = known.iter().find(|(each, _)| *each == signal).map(|(_, text)| *text);
    text.map_or_else(|| format!("signal {}", signal.as_raw()), str::to_owned)
}

/// Returns the last lines of the error file that EnergyPlus wrote last, below a folder.
fn last_messages(folder: &Path) -> String {
    let modified = |path: &PathBuf| path.metadata().and_then(|found| found.modified()).ok();
    let newest = error_files(folder).into_iter().max_by_key(modified);
    let text = newest.and_then(|path| std::fs::read(path).ok()).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    let last = &lines[lines.len().saturating_sub(LAST_LINES)..];
    if last.is_empty() { ".".into() } else { format!("; its last messages:\n  {}", last.join("\n  ")) }
}

fn error_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|found| found.is_dir()) {
            files.append(&mut error_files(&path));
        } else if path.file_name() == Some(OsStr::new("eplusout.err")) {
            files.push(path);
        }
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_limit_is_exceeded_unless_it_is_dropped_before() {
        let (exceeded, calls) = channel();
        let limit = |milliseconds, name| {
            let exceeded = exceeded.clone();
            TimeLimit::start(Duration::from_millis(milliseconds), move || exceeded.send(name).unwrap())
        };
        let _short = limit(1, "short");
        drop(limit(200, "dropped"));
        let _long = limit(400, "long");
        assert_eq!([calls.recv(), calls.recv()], [Ok("short"), Ok("long")]);
    }
}
