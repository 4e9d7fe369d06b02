//! Standard output, which is reserved for results.

use std::io::{ErrorKind, Write};

use anyhow::Result;
use serde::Serialize;

use crate::terminal::wrap;

/// Prints a text and a newline. On a terminal, lines are wrapped to its width.
pub fn print(text: &str) -> Result<()> {
    match wrap::width() {
        Some(width) => write(&wrap::lines(text, width)),
        None => write(text),
    }
}

fn write(text: &str) -> Result<()> {
    Ok(writeln!(std::io::stdout().lock(), "{text}")?)
}

/// Prints one JSON value and a newline.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    write(&serde_json::to_string_pretty(value)?)
}

/// Prints a result: as JSON, or as the text that `text` returns.
pub fn print_result(json: bool, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
    if json { print_json(value) } else { print(&text()) }
}

/// Returns whether an error only means that the reader closed the pipe (`b2b list | head -1`).
pub fn is_closed(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|io| io.kind() == ErrorKind::BrokenPipe)
}
