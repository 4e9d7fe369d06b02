//! Stamps of verified packages: the file system's metadata of every file when its contents were last verified.
//!
//! Reading a package takes a tenth of a second or more; reading metadata takes microseconds. If the size, a time or the
//! inode number of any file differs from the stamp, the package is read again.

use std::fs::Metadata;
use std::path::{Path, PathBuf};

use super::cache::Cache;
use super::manifest::Manifest;
use super::pinned::Package;
use b2b_base::aside::write_whole;
use b2b_base::digest::sha256;

/// The stamp of the files of a package in a folder.
pub(super) struct Stamp {
    /// The file that keeps the stamp of the last verification.
    path: PathBuf,
    text: String,
}

impl Stamp {
    /// Takes the stamp of the files of a manifest; `None` if one is missing.
    pub(super) fn of(package: &Package, manifest: &Manifest, root: &Path, cache: &Cache) -> Option<Self> {
        let mut all = format!("{} {}\n", root.display(), manifest.digest());
        for file in &manifest.files {
            let found = std::fs::metadata(root.join(&file.path)).ok()?;
            all.push_str(&line(&found));
        }
        let path = cache.root.join(format!(".{}.verified", package.stem()));
        Some(Self { path, text: sha256(all) })
    }

    /// Returns whether these files are unchanged since they were verified.
    pub(super) fn is_known(&self) -> bool {
        std::fs::read_to_string(&self.path).is_ok_and(|known| known == self.text)
    }

    /// Stores the stamp. In a read-only cache, the files are verified at every start.
    pub(super) fn keep(&self) {
        let _ = write_whole(&self.path, self.text.as_bytes());
    }
}

fn line(found: &Metadata) -> String {
    let changed = {
        use std::os::unix::fs::MetadataExt;
        (found.ino(), found.ctime(), found.ctime_nsec())
    };
    format!("{} {:?} {changed:?}\n", found.len(), found.modified().ok())
}
