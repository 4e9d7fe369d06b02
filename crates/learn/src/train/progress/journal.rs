//! Append-only files of whole entries.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use b2b_base::aside::append;

use crate::error::{Result, at};

/// An append-only file of whole entries. An entry that cannot be written completely, for example on a full disk, is
/// removed.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    length: u64,
}

impl Journal {
    /// Opens a file, or creates it, to append to.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = append(path).map_err(at(path))?;
        let length = file.metadata().map_err(at(path))?.len();
        Ok(Self { path: path.to_owned(), file, length })
    }

    /// Appends an entry.
    pub(super) fn append(&mut self, entry: &[u8]) -> Result<()> {
        let written = self.file.write_all(entry);
        match written {
            Ok(()) => self.length += entry.len() as u64,
            // Removes the part that was written; if that fails too, nothing else can be done.
            Err(_) => drop(self.file.set_len(self.length)),
        }
        written.map_err(at(&self.path))
    }

    /// Returns whether nothing was written to it yet.
    pub(super) fn is_empty(&self) -> bool {
        self.length == 0
    }
}
