//! Supervision of commands that run EnergyPlus in their own process.
//!
//! A model or a weather file can make EnergyPlus crash or run forever. Such a command therefore runs in a child
//! process. The supervisor forwards stop requests, kills a child that does not stop in time, and reports a crash with
//! the last messages of EnergyPlus. The folder with the child's temporary files is always removed.

use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use b2b_base::scratch::temporary_folder;
use rustix::process::{Pid, Signal, kill_process, set_parent_process_death_signal};

use crate::{ExitCode, program};

/// Environment variable that marks a supervised process.
pub const SUPERVISED: &str = "B2B_SUPERVISED";
/// Time that a process has to stop before it is killed. A second request kills it immediately.
pub const GRACE: Duration = Duration::from_secs(10);
/// Time limit for the preparation of a building.
const PREPARATION: Duration = Duration::from_secs(600);
/// The most that a time limit counts at once: a process that was stopped for longer was not preparing anything.
const TICK: Duration = Duration::from_secs(1);
/// Number of lines of the EnergyPlus error file that are reported after a crash.
const LAST_LINES: usize = 5;

static CHILD: OnceLock<Pid> = OnceLock::new();
static STOPPING: AtomicBool = AtomicBool::new(false);

/// Returns whether this process is supervised. If so, the first call ties its lifetime to that of its supervisor.
pub fn is_supervised() -> bool {
    static SUPERVISED_HERE: OnceLock<bool> = OnceLock::new();
    *SUPERVISED_HERE.get_or_init(|| {
        let supervised = std::env::var_os(SUPERVISED).is_some();
        if supervised {
            // If this fails, the process outlives a supervisor that is killed.
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
    // The owner is the parent of this process, not of the child.
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
        (None, Some(Signal::XFSZ)) => {
            bail!("a file exceeded the limit of `ulimit -f`; raise the limit")
        }
        (None, signal) => bail!(
            "EnergyPlus crashed with {}{}\nThe model or the weather file causes the crash: correct the objects named \
             in the messages, or remove objects until it runs",
            signal.map_or_else(|| status.to_string(), name),
            last_messages(folder.path())
        ),
    }
}

/// Forwards a stop request to the child; kills it if it does not stop in time, or on a second request.
fn stop() {
    let Some(child) = CHILD.get().copied() else { std::process::exit(ExitCode::Interrupted as i32) };
    // Fails if the process has just ended.
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

/// Starts the time limit for the preparation of a building, if this process is supervised: with some models EnergyPlus
/// never returns, and only a whole process can be stopped. After the limit, this process exits with an error.
pub fn preparation_limit(building: &impl Display) -> Option<TimeLimit> {
    let building = building.to_string();
    let fail = move || {
        eprintln!(
            "error: {building} was not prepared within {} min; simplify the model: EnergyPlus may never finish with \
             its geometry or its programs",
            PREPARATION.as_secs() / 60
        );
        std::process::exit(ExitCode::Failure as i32);
    };
    is_supervised().then(|| TimeLimit::start(PREPARATION, fail))
}

/// A limit on the time in which this process runs, and is not stopped. Canceled when dropped.
pub struct TimeLimit(#[expect(dead_code, reason = "dropping it ends the wait")] Sender<()>);

impl TimeLimit {
    /// Calls a function in another thread after the limit.
    pub fn start(limit: Duration, exceeded: impl FnOnce() + Send + 'static) -> Self {
        let (running, dropped) = channel();
        std::thread::spawn(move || {
            let mut left = limit;
            while !left.is_zero() {
                let tick = left.min(TICK);
                if dropped.recv_timeout(tick) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
                left -= tick;
            }
            exceeded();
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

/// Returns the last lines of the newest EnergyPlus error file below a folder.
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
