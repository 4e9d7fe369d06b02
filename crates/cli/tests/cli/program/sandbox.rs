//! The `b2b` program between two new folders.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use super::{failure_code, stderr};

pub const B2B: &str = env!("CARGO_BIN_EXE_b2b");

/// A new working folder and a new folder for temporary files.
pub struct Sandbox {
    pub work: TempDir,
    pub temporary: TempDir,
}

impl Sandbox {
    pub fn new() -> Self {
        Self { work: tempfile::tempdir().unwrap(), temporary: tempfile::tempdir().unwrap() }
    }

    pub fn command(&self, program: &str, arguments: &str) -> Command {
        let mut command = Command::new(program);
        command.args(arguments.split_whitespace()).current_dir(self.work.path());
        command.env("TMPDIR", self.temporary.path()).stdin(Stdio::null());
        command
    }

    pub fn b2b(&self, arguments: &str) -> Output {
        self.command(B2B, arguments).output().unwrap()
    }

    /// Returns the object that a run with `--json` prints.
    pub fn json(&self, arguments: &str) -> Value {
        let output = self.b2b(&format!("{arguments} --json"));
        assert!(output.status.success(), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).expect("standard output holds one JSON value alone")
    }

    /// Returns everything in the two folders.
    pub fn left_behind(&self) -> Vec<PathBuf> {
        let entries = |folder: &Path| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries(self.work.path()).chain(entries(self.temporary.path())).collect()
    }

    /// Asserts that a command fails with the code of its message, prints `words` on standard error and leaves nothing
    /// behind.
    pub fn assert_refused(&self, command: &mut Command, words: &[&str]) {
        let before = self.left_behind();
        let output = command.output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(failure_code(&said)), "{said}");
        assert!(said.starts_with("error: ") && !said.contains("panicked"), "{said}");
        for word in words {
            assert!(said.contains(word), "`{word}` is not in: {said}");
        }
        assert_eq!(String::from_utf8_lossy(&output.stdout), "");
        assert_eq!(self.left_behind(), before);
    }
}
