//! The line that EnergyPlus prints to standard error when it aborts a run, although console output is off.
//!
//! The caller's error already says why the run ended, so the line would only add noise. Standard error is redirected to
//! a file from the last message of an aborted run to its return, a few milliseconds.

use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::os::fd::{AsFd, OwnedFd};

/// Start of the last message of an aborted run.
const LAST_MESSAGE: &str = "EnergyPlus Terminated--";
/// The line to suppress.
const LINE: &[u8] = b"Program terminated: EnergyPlus Terminated--Error(s) Detected.\n";

/// Standard error, captured until drop, then printed without the line.
pub(crate) struct Withheld {
    stderr: OwnedFd,
    file: File,
}

impl Withheld {
    /// Captures standard error if this is the last message of an aborted run. `None` for other messages, or if the file
    /// cannot be created.
    pub(crate) fn after(message: &str) -> Option<Self> {
        message.trim_start().starts_with(LAST_MESSAGE).then(|| Self::begin().ok())?
    }

    fn begin() -> io::Result<Self> {
        let withheld =
            Self { stderr: io::stderr().as_fd().try_clone_to_owned()?, file: tempfile::tempfile()? };
        rustix::stdio::dup2_stderr(&withheld.file)?;
        Ok(withheld)
    }

    fn print(&mut self) -> io::Result<()> {
        let mut text = Vec::new();
        self.file.rewind()?;
        self.file.read_to_end(&mut text)?;
        io::stderr().write_all(&without_line(&text))
    }
}

impl Drop for Withheld {
    fn drop(&mut self) {
        // A failure to restore standard error cannot be reported anywhere.
        let _ = rustix::stdio::dup2_stderr(&self.stderr);
        let _ = self.print();
    }
}

fn without_line(text: &[u8]) -> Vec<u8> {
    match text.windows(LINE.len()).position(|window| window == LINE) {
        Some(at) => [&text[..at], &text[at + LINE.len()..]].concat(),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_abort_line_is_suppressed() {
        let text = [b"before\n", LINE, b"after\n"].concat();
        assert_eq!(without_line(&text), b"before\nafter\n");
        assert_eq!(without_line(b"another line\n"), b"another line\n");
    }
}
