//! `b2b` as somebody runs it in a folder.
#![allow(dead_code, reason = "every test file takes what it needs")]

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// The program with arguments that are separated by spaces.
pub fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_b2b"));
    command.args(arguments.split_whitespace()).current_dir(folder).stdin(Stdio::null());
    command
}

/// What it says and how it ends.
pub fn b2b(folder: &Path, arguments: &str) -> Output {
    command(folder, arguments).output().unwrap()
}

/// What it says on standard error.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The object that it prints with `--json`.
pub fn json(folder: &Path, arguments: &str) -> Value {
    let output = b2b(folder, &format!("{arguments} --json"));
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}
