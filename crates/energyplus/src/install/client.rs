//! The user's Python package client: the one program that knows their proxies, mirrors and certificates.

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::error::at;
use super::progress::Task;
use super::{Cache, Error, Platform, Result};

/// Commands that may be a package client, best first.
const CANDIDATES: &[&[&str]] = &[
    &["python3", "-m", "pip"],
    &["python", "-m", "pip"],
    &["pip3"],
    &["pip"],
    &["uv", "tool", "run", "pip"],
];

/// How often a running download is looked at.
const POLL: Duration = Duration::from_millis(50);

/// A package client that answered.
pub(super) struct Client {
    command: &'static [&'static str],
    /// What it says of itself: version and place.
    pub(super) version: String,
}

impl Client {
    /// The first client of this machine that answers.
    pub(super) fn find() -> Option<Self> {
        CANDIDATES.iter().find_map(|&command| {
            let output = start(command).arg("--version").output().ok()?;
            let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            (output.status.success() && version.starts_with("pip ")).then_some(Self { command, version })
        })
    }

    /// The commands [`Client::find`] tries, for a message.
    pub(super) fn candidates() -> String {
        let commands: Vec<_> = CANDIDATES.iter().map(|words| words.join(" ")).collect();
        format!("`{}`", commands.join("`, `"))
    }

    /// Downloads `requirement` (`name==version`) into `destination`. Scratch files go into `scratch`, where
    /// they also tell how far it is: the client itself cannot. `bytes` is what is expected.
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
            // Only data is taken out: the Python that runs the client need not suit the package.
            .arg("--ignore-requires-python")
            .arg("--dest")
            .arg(destination);
        if let Some(tag) = platform.tag() {
            command.args(["--platform", tag]);
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

/// A command with no way to ask the user anything.
fn start(words: &[&str]) -> Command {
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).stdin(Stdio::null());
    // A group of its own, so that it can be ended with what it starts: `python3` and `uv` may be wrappers.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}

/// A child that does not outlive us: killed with all it started when we fail, are cancelled or unwind.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Once it has ended its number may be another's.
        if !matches!(self.0.try_wait(), Ok(None)) {
            return;
        }
        #[cfg(unix)]
        let _ = rustix::process::kill_process_group(
            rustix::process::Pid::from_child(&self.0),
            rustix::process::Signal::KILL,
        );
        // Both fail only when it has ended by itself meanwhile.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Bytes in a folder; what vanishes meanwhile counts as nothing.
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
