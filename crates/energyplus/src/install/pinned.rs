//! Packages pinned to a version, with their wheels and the files to unpack.

use std::fmt;

use super::error::{Error, Result};

/// A package of the registry at one version. Only files that match [`Package::keep`] are unpacked.
#[derive(Debug, PartialEq)]
pub struct Package {
    /// Name in the registry.
    pub name: &'static str,
    /// The pinned version.
    pub version: &'static str,
    /// Wheels, one per platform.
    pub wheels: &'static [Wheel],
    /// Paths of the wanted files in the wheel. A `*` matches any characters but `/`.
    pub keep: &'static [&'static str],
    /// Corrections of misspelled file names: the word in the wheel, and its replacement.
    pub corrections: &'static [(&'static str, &'static str)],
}

/// A wheel of a package.
#[derive(Debug, PartialEq)]
pub struct Wheel {
    /// Platform.
    pub platform: Platform,
    /// File name.
    pub file_name: &'static str,
    /// SHA-256, hexadecimal.
    pub sha256: &'static str,
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256 of the list of its wanted files ([`Manifest::digest`](super::Manifest::digest)).
    pub files_sha256: &'static str,
}

/// Platform of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Platform {
    /// Any platform: data or pure Python.
    Any,
    /// Linux with glibc, on an architecture.
    Linux(&'static str),
}

impl Platform {
    fn is_here(self) -> bool {
        match self {
            Self::Any => true,
            Self::Linux(architecture) => std::env::consts::ARCH == architecture,
        }
    }

    /// Returns the platform tag of a wheel (PEP 425); `None` for [`Platform::Any`].
    pub(super) fn tag(self) -> Option<String> {
        match self {
            Self::Any => None,
            Self::Linux(architecture) => Some(format!("manylinux1_{architecture}")),
        }
    }
}

impl fmt::Display for Package {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}=={}", self.name, self.version)
    }
}

impl Package {
    /// Returns whether a file of the wheel is wanted.
    pub(super) fn wants(&self, path: &str) -> bool {
        self.keep.iter().any(|pattern| match pattern.split_once('*') {
            None => *pattern == path,
            Some((start, end)) => path
                .strip_prefix(start)
                .and_then(|rest| rest.strip_suffix(end))
                .is_some_and(|middle| !middle.contains('/')),
        })
    }

    /// Returns the path of a file after unpacking.
    pub(super) fn corrected(&self, path: &str) -> String {
        self.corrections.iter().fold(path.to_owned(), |path, (wrong, right)| path.replace(wrong, right))
    }

    /// Returns the wheel for this machine. On a platform without a wheel, returns the first one, whose data files can
    /// still be used.
    pub(super) fn wheel(&self) -> &'static Wheel {
        self.native_wheel().unwrap_or(&self.wheels[0])
    }

    /// Returns an error if there is no wheel for this machine: its libraries cannot be loaded.
    pub(super) fn require_native(&self) -> Result<()> {
        self.native_wheel().map(|_| ()).ok_or_else(|| Error::NoWheel {
            package: self.to_string(),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        })
    }

    fn native_wheel(&self) -> Option<&'static Wheel> {
        self.wheels.iter().find(|wheel| wheel.platform.is_here())
    }

    /// Returns the name of the package's folder in the cache.
    pub(super) fn stem(&self) -> String {
        format!("{}-{}", self.name, self.version)
    }
}
