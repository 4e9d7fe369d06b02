//! Standard output: results only, in one piece.

use std::io::{ErrorKind, Write};

use anyhow::Result;
use serde::Serialize;

/// Prints a text and a newline.
pub fn print(text: &str) -> Result<()> {
    Ok(writeln!(std::io::stdout().lock(), "{text}")?)
}

/// Prints one JSON value and a newline.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    print(&serde_json::to_string_pretty(value)?)
}

/// Whether an error only says that nobody reads any more (`b2b list | head -1`).
pub fn is_closed(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|io| io.kind() == ErrorKind::BrokenPipe)
}
