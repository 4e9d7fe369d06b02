//! The `b2b` program, run in a folder.

pub mod sandbox;

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

/// Returns the program with arguments that are separated by spaces.
pub fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_b2b"));
    command.args(arguments.split_whitespace()).current_dir(folder).stdin(Stdio::null());
    command
}

/// Runs the program to its end.
pub fn b2b(folder: &Path, arguments: &str) -> Output {
    command(folder, arguments).output().unwrap()
}

/// Returns its standard error.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Returns its standard output and standard error.
pub fn both_outputs(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(output))
}

/// Returns the object that it prints with `--json`.
pub fn json(folder: &Path, arguments: &str) -> Value {
    let output = b2b(folder, &format!("{arguments} --json"));
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Returns the exit code that belongs to a message: 2 if the arguments are wrong, otherwise 1.
pub fn failure_code(message: &str) -> i32 {
    if message.contains("For more information, try '--help'") { 2 } else { 1 }
}

/// Asserts that a command fails with the code of its message, which contains all words.
pub fn assert_rejected(folder: &Path, arguments: &str, words: &[&str]) {
    let output = b2b(folder, arguments);
    let message = both_outputs(&output);
    assert_eq!(output.status.code(), Some(failure_code(&message)), "{arguments}: {message}");
    assert!(!message.contains("panicked"), "{arguments}: {message}");
    for word in words {
        assert!(message.contains(word), "{arguments}: `{word}` is not in: {message}");
    }
}

/// Returns the worker processes of a process: templates, and the copies of them that run episodes.
pub fn workers_of(owner: u32) -> Vec<u32> {
    let owner = owner.to_string();
    let worker = |process: std::fs::DirEntry| {
        let line = std::fs::read_to_string(process.path().join("cmdline")).ok()?;
        let mut arguments = line.split('\0').skip_while(|argument| *argument != "--b2b-worker").skip(1);
        (arguments.next() == Some(&owner)).then(|| process.file_name().to_str()?.parse().ok())?
    };
    std::fs::read_dir("/proc").unwrap().flatten().filter_map(worker).collect()
}

/// Waits until a condition holds.
///
/// # Panics
/// If it does not happen within five minutes.
pub fn wait_until(mut has_happened: impl FnMut() -> bool) {
    for _ in 0..30_000 {
        if has_happened() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("it did not happen within five minutes");
}
