//! The digests of a folder's files in `SHA256SUMS`, which `sha256sum --check` reads too. The files themselves are
//! unchanged.

use std::collections::BTreeMap;
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

use crate::aside::write_whole;
use crate::digest::sha256;

/// Name of the file.
pub const DIGESTS: &str = "SHA256SUMS";

/// Digests of files by their paths in the folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DigestList(BTreeMap<String, String>);

impl DigestList {
    /// Adds the content of a file.
    pub fn add(&mut self, name: impl Into<String>, content: &[u8]) {
        self.0.insert(name.into(), sha256(content));
    }

    /// Writes the digests to a folder.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let lines: String = self.0.iter().map(|(name, digest)| format!("{digest}  {name}\n")).collect();
        write_whole(&folder.join(DIGESTS), lines.as_bytes())
    }

    /// Reads a folder's digests; `None` if it has none, like folders from earlier versions.
    ///
    /// # Errors
    /// Errors of the operating system, and [`ErrorKind::InvalidData`] for a damaged list.
    pub fn read(folder: &Path) -> Result<Option<Self>> {
        let text = match std::fs::read_to_string(folder.join(DIGESTS)) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            text => text?,
        };
        let line = |line: &str| {
            let (digest, name) = line.split_once("  ")?;
            Some((name.to_owned(), digest.to_owned()))
        };
        let digests: Option<_> = text.lines().map(line).collect();
        digests.map(|digests| Some(Self(digests))).ok_or_else(|| invalid(format!("{DIGESTS} is damaged")))
    }

    /// Reads a file in a folder and compares it with its digest.
    ///
    /// # Errors
    /// Errors of the operating system, and [`ErrorKind::InvalidData`] for a file that was changed or is not listed.
    pub fn read_file(&self, folder: &Path, name: &str) -> Result<Vec<u8>> {
        let content = std::fs::read(folder.join(name))?;
        match self.0.get(name) {
            Some(digest) if *digest == sha256(&content) => Ok(content),
            Some(_) => Err(invalid(format!("it was changed: its SHA-256 is not the one in {DIGESTS}"))),
            None => Err(invalid(format!("it is not listed in {DIGESTS}"))),
        }
    }
}

/// Reads a file of a folder, and compares it with its digest if the folder has digests.
///
/// # Errors
/// Errors from [`DigestList::read`] and [`DigestList::read_file`].
pub fn read_verified(folder: &Path, name: &str) -> Result<Vec<u8>> {
    match DigestList::read(folder)? {
        Some(digests) => digests.read_file(folder, name),
        None => std::fs::read(folder.join(name)),
    }
}

fn invalid(why: String) -> Error {
    Error::new(ErrorKind::InvalidData, why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_of_a_file_and_of_its_digest_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        std::fs::write(&path, "{\"a\": 1}").unwrap();
        assert_eq!(read_verified(folder.path(), "a.json").unwrap(), b"{\"a\": 1}", "without digests");
        let mut digests = DigestList::default();
        digests.add("a.json", b"{\"a\": 1}");
        digests.write(folder.path()).unwrap();
        read_verified(folder.path(), "a.json").unwrap();
        for file in [path, folder.path().join(DIGESTS)] {
            let whole = std::fs::read(&file).unwrap();
            // A missing line feed at the end changes nothing.
            for bit in 0..8 * (whole.len() - usize::from(file.ends_with(DIGESTS))) {
                let mut damaged = whole.clone();
                damaged[bit / 8] ^= 1 << (bit % 8);
                std::fs::write(&file, damaged).unwrap();
                assert!(read_verified(folder.path(), "a.json").is_err(), "bit {bit} of {}", file.display());
            }
            std::fs::write(&file, whole).unwrap();
        }
    }
}
