//! The program under attack: its start, and the conditions that must hold after its end.

use std::ffi::OsString;
use std::fs::File;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

/// The program.
pub struct Program {
    path: PathBuf,
}

/// A process of the program with its own temporary folder, which identifies its children.
pub struct Run {
    child: Child,
    began: Instant,
    outputs: TempDir,
    temporary: TempDir,
}

/// A process that has ended.
pub struct Ended {
    /// Exit status; `None` if the process was killed because it ran too long.
    pub status: Option<ExitStatus>,
    /// Standard output.
    pub output: String,
    /// Standard error.
    pub errors: String,
    /// Files that it left in its temporary folder.
    pub left: Vec<PathBuf>,
    /// Number of its children that were still running.
    pub survivors: usize,
}

impl Program {
    /// Returns the program at a path. Errors if there is none.
    pub fn new(path: PathBuf) -> Result<Self> {
        if !path.is_file() {
            bail!(
                "{} does not exist; build it with `cargo build --release`, or use --program",
                path.display()
            );
        }
        Ok(Self { path: path.canonicalize()? })
    }

    /// Starts the program in a folder. `limits` are `ulimit` commands, run by the shell before it.
    pub fn start(&self, folder: &Path, limits: &str, arguments: &[OsString]) -> Result<Run> {
        let (outputs, temporary) = (tempfile::tempdir()?, tempfile::tempdir()?);
        let file = |name| File::create(outputs.path().join(name));
        let mut command = Command::new("/bin/sh");
        command.arg("-c").arg(format!("{limits}\nexec \"$@\"")).arg("sh").arg(&self.path).args(arguments);
        command.current_dir(folder).env("TMPDIR", temporary.path()).stdin(Stdio::null());
        command.stdout(file("stdout")?).stderr(file("stderr")?);
        let child = command.spawn().context("cannot start /bin/sh")?;
        Ok(Run { child, began: Instant::now(), outputs, temporary })
    }

    /// Runs the program in a folder and kills it after the time limit.
    pub fn run(&self, folder: &Path, arguments: &[OsString], limit: Duration) -> Result<Ended> {
        self.start(folder, "", arguments)?.end(limit)
    }

    /// Runs the program with arguments separated by spaces. Errors unless it succeeds.
    pub fn must(&self, folder: &Path, arguments: &str) -> Result<()> {
        let ended = self.run(folder, &words(arguments), Duration::from_secs(600))?;
        if !ended.status.is_some_and(|status| status.success()) {
            bail!("b2b {arguments} failed: {}", ended.errors);
        }
        Ok(())
    }
}

/// Splits arguments at spaces.
pub fn words(arguments: &str) -> Vec<OsString> {
    arguments.split_whitespace().map(Into::into).collect()
}

impl Run {
    /// Returns whether the process has ended.
    pub fn has_ended(&mut self) -> Result<bool> {
        Ok(self.child.try_wait()?.is_some())
    }

    /// Returns the process and its children that are still running.
    pub fn processes(&self) -> Vec<Pid> {
        let mark = format!("TMPDIR={}", self.temporary.path().display());
        let mut found = Vec::new();
        for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
            let id = entry.file_name().to_string_lossy().parse().ok().and_then(Pid::from_raw);
            let environment = std::fs::read(entry.path().join("environ")).unwrap_or_default();
            // A child may have a temporary folder inside its parent's.
            let is_its = environment.split(|byte| *byte == 0).any(|each| each.starts_with(mark.as_bytes()));
            found.extend(id.filter(|_| is_its));
        }
        found
    }

    /// Waits for the end of the process, and interrupts it if it is still running `time` after its start.
    pub fn interrupt_after(&mut self, time: Duration) -> Result<()> {
        if self.wait_until(time)?.is_none() {
            kill_process(Pid::from_child(&self.child), Signal::INT)?;
        }
        Ok(())
    }

    /// Waits for the end of the process, and kills it if it is still running `limit` after its start.
    pub fn end(mut self, limit: Duration) -> Result<Ended> {
        let status = self.wait_until(limit)?;
        let survivors = if status.is_some() { self.survivors() } else { 0 };
        for process in self.processes() {
            // Fails if the process has just ended.
            let _ = kill_process(process, Signal::KILL);
        }
        if status.is_none() {
            self.child.wait()?;
        }
        let read = |name| std::fs::read(self.outputs.path().join(name));
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        let entries = std::fs::read_dir(self.temporary.path())?;
        let left = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
        Ok(Ended { status, output: text(read("stdout")?), errors: text(read("stderr")?), left, survivors })
    }

    /// Waits for the end of the process; `None` if it is still running `time` after its start.
    fn wait_until(&mut self, time: Duration) -> Result<Option<ExitStatus>> {
        loop {
            let status = self.child.try_wait()?;
            if status.is_some() || self.began.elapsed() > time {
                return Ok(status);
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Returns the number of children that are still running 10 s after their parent's end.
    fn survivors(&self) -> usize {
        let deadline = Instant::now() + Duration::from_secs(10);
        loop {
            match self.processes().len() {
                0 => return 0,
                number if Instant::now() > deadline => return number,
                _ => std::thread::sleep(Duration::from_millis(50)),
            }
        }
    }
}

impl Ended {
    /// Returns the exit code, if it ended by itself.
    pub fn code(&self) -> Option<i32> {
        self.status.and_then(|status| status.code())
    }

    /// Returns the first violated guarantee: an endless run, a panic, a running child, a signal, an unknown exit code,
    /// or a file left behind. Checks only the first three if the process was `killed`.
    pub fn broken(&self, killed: bool) -> Option<String> {
        let Some(status) = self.status else { return Some("it does not end".into()) };
        if self.errors.contains("panicked at") {
            return Some(format!("panic: {}", self.errors));
        }
        if self.survivors > 0 {
            return Some(format!("{} of its processes are still running", self.survivors));
        }
        if killed {
            return None;
        }
        if let Some(signal) = status.signal() {
            return Some(format!("signal {signal}: {}", self.errors));
        }
        if !matches!(status.code(), Some(0 | 1 | 2 | 130)) {
            return Some(format!("exit code {:?}: {}", status.code(), self.errors));
        }
        (!self.left.is_empty()).then(|| format!("left in the temporary folder: {:?}", self.left))
    }
}
