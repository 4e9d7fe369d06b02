//! The line that EnergyPlus prints to standard error when it aborts a run, although console output is off.
//!
//! The error that the caller gets says why the run ended, so the line would only add noise to the output of the program. What a
//! process prints from the last message of an aborted run to its return, a few milliseconds, passes through a file.

use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::os::fd::{AsFd, OwnedFd};

/// The beginning of the last message of a run that is aborted.
const LAST_MESSAGE: &str = "EnergyPlus Terminated--";
/// The line.
const LINE: &[u8] = b"Program terminated: EnergyPlus Terminated--Error(s) Detected.\n";

/// Standard error, withheld until drop, which prints it without the line.
pub(crate) struct Withheld {
    stderr: OwnedFd,
    file: File,
}

impl Withheld {
    /// Withholds standard error if this is the last message of an aborted run. `None` otherwise, and if the file cannot be made.
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
        // Standard error is there, and if nothing can be printed, nobody can be told.
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
    fn only_the_line_is_left_out() {
        let text = [b"before\n", LINE, b"after\n"].concat();
        assert_eq!(without_line(&text), b"before\nafter\n");
        assert_eq!(without_line(b"another line\n"), b"another line\n");
    }
}
