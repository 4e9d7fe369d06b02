//! Confined runs of the programs of an EnergyPlus folder.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::confinement::{Confinement, confined_to_program};

/// Loaders of dynamically linked programs, which the kernel runs with them.
const LOADERS: [&str; 2] = ["/lib64/ld-linux-x86-64.so.2", "/lib/ld-musl-x86_64.so.1"];
/// Interval at which a running program is polled.
const PAUSE: Duration = Duration::from_millis(5);

/// A program that has ended.
#[derive(Debug)]
pub struct Ended {
    /// Exit status.
    pub status: ExitStatus,
    /// Standard output.
    pub output: String,
    /// How far it was confined.
    pub confinement: Confinement,
}

/// Runs a program with arguments in a folder to its end. As far as the kernel supports it ([`Confinement`]), the
/// program can write only in this folder, and cannot start others or connect to a network.
///
/// # Errors
/// [`ErrorKind::TimedOut`] for a program that was stopped after `limit`; the errors of starting it.
pub fn run_program(program: &Path, arguments: &[&str], folder: &Path, limit: Duration) -> Result<Ended> {
    let mut runs = vec![program.to_owned()];
    runs.extend(script_program(program)?);
    runs.extend(LOADERS.map(PathBuf::from));
    let mut said = tempfile::tempfile_in(folder)?;
    let output = said.try_clone()?;
    let mut command = Command::new(program);
    command.args(arguments).current_dir(folder).stdin(Stdio::null()).stdout(output).stderr(Stdio::null());
    let (confinement, status) = confined_to_program(folder, &runs, || run(command, limit));
    let status = status?;
    let mut text = Vec::new();
    std::io::Seek::rewind(&mut said)?;
    said.read_to_end(&mut text)?;
    Ok(Ended { status, output: String::from_utf8_lossy(&text).into_owned(), confinement })
}

fn run(mut command: Command, limit: Duration) -> Result<ExitStatus> {
    let mut child = command.spawn()?;
    let end = Instant::now() + limit;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if Instant::now() >= end {
            child.kill()?;
            child.wait()?;
            let why = format!("it did not end within {} s", limit.as_secs_f64());
            return Err(Error::new(ErrorKind::TimedOut, why));
        }
        sleep(PAUSE);
    }
}

/// Returns the interpreter named in the first line of a script.
fn script_program(path: &Path) -> Result<Option<PathBuf>> {
    let mut start = Vec::new();
    File::open(path)?.take(256).read_to_end(&mut start)?;
    let line = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let words = line.strip_prefix(b"#!").map(|words| String::from_utf8_lossy(words).into_owned());
    Ok(words.and_then(|words| words.split_whitespace().next().map(PathBuf::from)))
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    const LONG: Duration = Duration::from_secs(20);

    /// Runs a script in a folder below a new one.
    fn run_script(script: &str, limit: Duration) -> (tempfile::TempDir, Result<Ended>) {
        let root = tempfile::tempdir().unwrap();
        let (program, folder) = (root.path().join("program"), root.path().join("work"));
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let result = run_program(&program, &[], &folder, limit);
        (root, result)
    }

    #[test]
    fn a_program_writes_only_in_its_folder_and_starts_no_other() {
        let (root, result) = run_script("echo said; echo a > inside; echo b > ../outside; /bin/true", LONG);
        let Ended { status, output, confinement } = result.unwrap();
        assert_eq!(output, "said\n");
        assert_eq!(confinement, Confinement::available(), "it says how far");
        assert!(root.path().join("work/inside").exists());
        if confinement != Confinement::None {
            assert!(!root.path().join("outside").exists());
            assert!(!status.success(), "/bin/true was started");
        }
    }

    #[test]
    fn a_program_that_does_not_end_is_stopped() {
        let (_, result) = run_script("while :; do :; done", Duration::from_millis(200));
        let error = result.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::TimedOut);
        assert!(error.to_string().contains("0.2 s"), "{error}");
    }
}
