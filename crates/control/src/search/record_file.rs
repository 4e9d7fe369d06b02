//! Files of results, one line each, from which an interrupted search resumes.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use b2b_base::aside::append;
use serde::Serialize;

use crate::{Error, Result};

/// A file whose first line is what a search depends on; every further line is a result.
pub(crate) struct RecordFile {
    path: PathBuf,
    file: File,
}

impl RecordFile {
    /// Opens the file of a search, or creates it, and returns its results as text. An incomplete last line is dropped.
    ///
    /// # Errors
    /// [`Error::OtherTuning`] for the file of another search; [`Error::Io`].
    pub(crate) fn open(path: &Path, head: &impl Serialize) -> Result<(Self, Vec<String>)> {
        let io = |source| Error::Io { path: path.to_owned(), source };
        let head = serde_json::to_string(head).expect("plain data always serializes") + "\n";
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            text => text.map_err(io)?,
        };
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let lines = match whole.strip_prefix(head.as_str()) {
            Some(lines) => lines,
            None if whole.is_empty() => "",
            None => {
                let why = format!("it starts with {}", whole.lines().next().unwrap_or_default());
                return Err(Error::OtherTuning { path: path.to_owned(), why });
            }
        };
        let mut file = append(path).map_err(io)?;
        file.set_len(whole.len() as u64).map_err(io)?;
        if whole.is_empty() {
            file.write_all(head.as_bytes()).map_err(io)?;
        }
        Ok((Self { path: path.to_owned(), file }, lines.lines().map(str::to_owned).collect()))
    }

    /// Appends a result.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(crate) fn push(&mut self, result: &impl Serialize) -> Result<()> {
        let line = serde_json::to_string(result).expect("plain data always serializes") + "\n";
        let written = self.file.write_all(line.as_bytes());
        written.map_err(|source| Error::Io { path: self.path.clone(), source })
    }

    /// Returns the error for a line that cannot belong to this search.
    pub(crate) fn other(&self, why: String) -> Error {
        Error::OtherTuning { path: self.path.clone(), why }
    }
}
