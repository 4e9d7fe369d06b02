//! The user's Python package client, which is configured for their proxies, mirrors and certificates.

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::cache::Cache;
use super::error::{Error, Result, at};
use super::pinned::Platform;
use super::progress::Task;

/// Commands of package clients, in order of preference. `-I`, because `-m` otherwise imports from the current folder.
const CANDIDATES: &[&[&str]] = &[
    &["python3", "-I", "-m", "pip"],
    &["python", "-I", "-m", "pip"],
    &["pip3"],
    &["pip"],
    &["uv", "tool", "run", "pip"],
];

/// Interval at which a running download is polled.
const POLL: Duration = Duration::from_millis(50);

/// Folder in which clients run.
const FOLDER: &str = "/";

/// A working package client.
pub(super) struct Client {
    command: &'static [&'static str],
    /// Version and location, as the client reports them.
    pub(super) version: String,
}

impl Client {
    /// Returns the first working client of this machine.
    pub(super) fn find() -> Option<Self> {
        CANDIDATES.iter().find_map(|&command| {
            let output = start(command).arg("--version").output().ok()?;
            let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            (output.status.success() && version.starts_with("pip ")).then_some(Self { command, version })
        })
    }

    /// Returns the commands that [`Client::find`] tries, for a message.
    pub(super) fn candidates() -> String {
        let commands: Vec<_> = CANDIDATES.iter().map(|words| words.join(" ")).collect();
        format!("`{}`", commands.join("`, `"))
    }

    /// Downloads `requirement` (`name==version`), `bytes` in size, into `destination`. Temporary files are in
    /// `scratch`, where their size shows the progress, which the client does not report.
    pub(super) fn download(
        &self,
        requirement: &str,
        platform: Platform,
        [destination, scratch]: [&Path; 2],
        bytes: u64,
        cache: &Cache,
        task: &mut Task,
    ) -> Result<()> {
        let messages = scratch.join("messages.txt");
        let log = File::create(&messages).map_err(at(&messages))?;
        let mut command = start(self.command);
        command
            .args(["download", "--quiet", "--no-input", "--progress-bar", "off"])
            .args(["--no-cache-dir", "--disable-pip-version-check"])
            .args(["--retries", "2", "--no-deps", "--only-binary", ":all:"])
            // Only data files are used: the Python version of the client does not matter.
            .arg("--ignore-requires-python")
            .arg("--dest")
            .arg(destination);
        if let Some(tag) = platform.tag() {
            command.args(["--platform", &tag]);
        }
        command
            .arg(requirement)
            .env("PIP_REQUIRE_VIRTUALENV", "0")
            .envs(["TMPDIR", "TEMP", "TMP"].map(|name| (name, scratch)))
            .envs(cache.client_environment.iter().map(|(k, v)| (k, v)))
            .stdout(Stdio::null())
            .stderr(log);
        let spawned = command.spawn().map_err(at(self.command[0]))?;
        let mut child = Running(spawned);
        let status = loop {
            if let Some(status) = child.0.try_wait().map_err(at(self.command[0]))? {
                break status;
            }
            let done = size(scratch).max(size(destination));
            task.advance(done.min(bytes))?;
            std::thread::sleep(POLL);
        };
        if status.success() {
            return task.advance(bytes);
        }
        Err(Error::Download { package: requirement.to_owned(), said: last_lines(&messages, 4) })
    }
}

/// Creates a command without standard input, in a folder to which only the administrator can write: interpreters and
/// package clients read code and settings from the current folder and its parents, which others may have written.
fn start(words: &[&str]) -> Command {
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).stdin(Stdio::null()).current_dir(FOLDER);
    // A separate process group, so that it can be ended with its children: `python3` and `uv` may be wrappers.
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}

/// A child process that is killed with its own children on drop.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // After its end, the id may belong to another process.
        if !matches!(self.0.try_wait(), Ok(None)) {
            return;
        }
        let _ = rustix::process::kill_process_group(
            rustix::process::Pid::from_child(&self.0),
            rustix::process::Signal::KILL,
        );
        // Both fail only if it has ended in the meantime.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Returns the size of a folder in bytes; files that vanish in the meantime count as 0.
fn size(folder: &Path) -> u64 {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return 0;
    };
    entries
        .flatten()
        .map(|entry| match entry.metadata() {
            Ok(found) if found.is_dir() => size(&entry.path()),
            Ok(found) => found.len(),
            Err(_) => 0,
        })
        .sum()
}

fn last_lines(path: &Path, count: usize) -> String {
    let text = std::fs::read(path).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<_> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    let last = &lines[lines.len().saturating_sub(count)..];
    last.iter().map(|line| format!("  {line}\n")).collect::<String>().trim_end().to_owned()
}
