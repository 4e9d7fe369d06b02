//! EPW files, each read only once although several parts of a program need it.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::SystemTime;

use b2b_base::digest::sha256;

use super::{Header, Record};
use crate::{ClimateYear, DegreeDays, Error, Result, Site};

/// Number of files that are kept in memory, about 2 MB each.
const KEPT: usize = 4;

/// An EPW file.
#[derive(Debug)]
pub struct EpwFile {
    path: PathBuf,
    stamp: Stamp,
    /// Without byte order mark.
    text: String,
    sha256: String,
    /// The hours, or why they cannot be read.
    record: OnceLock<std::result::Result<Record, String>>,
}

/// The state of a file when it was read: a changed file is read again.
#[derive(Debug, PartialEq, Eq)]
struct Stamp {
    bytes: u64,
    modified: Option<SystemTime>,
    /// Inode and time of its last change.
    changed: (u64, i64, i64),
}

/// The files that were opened last, the latest at the end.
static OPENED: Mutex<Vec<Arc<EpwFile>>> = Mutex::new(Vec::new());

impl EpwFile {
    /// Returns a file, from memory if it was read before and has not changed.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read.
    pub fn open(path: &Path) -> Result<Arc<Self>> {
        let at = |source| Error::Io { path: path.to_owned(), source };
        let stamp = Stamp::of(path).map_err(at)?;
        let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
        let known = opened.iter().position(|file| file.path == path && file.stamp == stamp);
        let file = match known {
            Some(index) => opened.remove(index),
            None => {
                let bytes = std::fs::read(path).map_err(at)?;
                let text = String::from_utf8_lossy(&bytes);
                let text = text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned();
                Arc::new(Self {
                    path: path.to_owned(),
                    stamp,
                    text,
                    sha256: sha256(&bytes),
                    record: OnceLock::new(),
                })
            }
        };
        opened.retain(|other| other.path != path);
        if opened.len() == KEPT {
            opened.remove(0);
        }
        opened.push(Arc::clone(&file));
        Ok(file)
    }

    /// Returns the SHA-256 of the file, in hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Returns the text, without byte order mark.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Returns the hours.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line and the reason.
    pub fn record(&self) -> Result<&Record> {
        let read = self.record.get_or_init(|| Record::read(&self.text));
        read.as_ref().map_err(|why| Error::Malformed { path: self.path.clone(), why: why.clone() })
    }

    /// Checks that the engine can read the file.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the reason.
    pub fn check(&self) -> Result<()> {
        match self.record()?.span() {
            Some(_) => Ok(()),
            None => Err(Error::Malformed {
                path: self.path.clone(),
                why: "it has no hours of weather".to_owned(),
            }),
        }
    }

    /// Returns the site.
    ///
    /// # Errors
    /// The errors of [`Site::from_epw`].
    pub fn site(&self) -> Result<Site> {
        Site::of(&Header { text: &self.text, path: &self.path }, self.record()?)
    }

    /// Returns the degree-days of the hours.
    ///
    /// # Errors
    /// The errors of [`EpwFile::record`].
    pub fn degree_days(&self) -> Result<DegreeDays> {
        Ok(DegreeDays::of(self.record()?))
    }

    /// Returns the climate of the year; `None` if a day of the year is missing.
    ///
    /// # Errors
    /// The errors of [`EpwFile::record`].
    pub fn year(&self) -> Result<Option<ClimateYear>> {
        Ok(ClimateYear::of(self.record()?))
    }
}

impl Stamp {
    fn of(path: &Path) -> std::io::Result<Self> {
        let found = std::fs::metadata(path)?;
        let changed = {
            use std::os::unix::fs::MetadataExt;
            (found.ino(), found.ctime(), found.ctime_nsec())
        };
        Ok(Self { bytes: found.len(), modified: found.modified().ok(), changed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_again_only_when_it_has_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.epw");
        std::fs::write(&path, "one").unwrap();
        let first = EpwFile::open(&path).unwrap();
        assert!(Arc::ptr_eq(&first, &EpwFile::open(&path).unwrap()));
        std::fs::write(&path, "other").unwrap();
        let second = EpwFile::open(&path).unwrap();
        assert!(first.sha256() != second.sha256());
        std::fs::remove_file(&path).unwrap();
        assert!(EpwFile::open(&path).unwrap_err().to_string().contains("a.epw"));
    }

    #[test]
    fn few_files_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        for number in 0..2 * KEPT {
            let path = folder.path().join(format!("{number}.epw"));
            std::fs::write(&path, number.to_string()).unwrap();
            EpwFile::open(&path).unwrap();
        }
        assert!(OPENED.lock().unwrap().len() <= KEPT);
    }
}
