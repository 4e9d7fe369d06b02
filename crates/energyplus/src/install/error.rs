//! Errors of the installation of EnergyPlus and weather packages.

use std::path::PathBuf;

use super::ENGINE_VERSION;

/// An error of the installation.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No folder for the cache.
    #[error("cannot determine the cache folder, as the home folder is unknown: set B2B_CACHE to a folder")]
    NoCacheFolder,
    /// No Python package client for a download.
    #[error(
        "cannot download {package}: no Python package client was found (tried {tried}). Install Python 3 with pip, \
         or copy the cache folder of another machine and set B2B_CACHE"
    )]
    NoClient {
        /// The package, as `name==version`.
        package: String,
        /// The commands that were tried.
        tried: String,
    },
    /// A platform without a wheel.
    #[error(
        "{package} has no wheel for {platform}; expected Linux x86_64. Elsewhere, install EnergyPlus {version} and set \
         B2B_ENERGYPLUS to its folder",
        version = ENGINE_VERSION
    )]
    NoWheel {
        /// The package, as `name==version`.
        package: String,
        /// This machine, as `os arch`.
        platform: String,
    },
    /// A download that the settings forbid.
    #[error("{package} is missing or damaged in {cache}, and B2B_OFFLINE forbids downloads: {ADVICE}")]
    Offline {
        /// The package, as `name==version`.
        package: String,
        /// The cache folder.
        cache: PathBuf,
    },
    /// A failure of the package client.
    #[error(
        "cannot download {package}; messages of the package client:\n{said}\nIf this machine is offline: {ADVICE}"
    )]
    Download {
        /// The package, as `name==version`.
        package: String,
        /// Last lines of the messages of the client.
        said: String,
    },
    /// A downloaded wheel whose SHA-256 differs from the pinned one.
    #[error(
        "{file} has SHA-256 {found}; expected {expected}. The registry or mirror served a different file: try again, or \
         use another mirror"
    )]
    Checksum {
        /// The wheel's file name.
        file: String,
        /// The pinned SHA-256.
        expected: String,
        /// The SHA-256 of the download.
        found: String,
    },
    /// A wheel that cannot be unpacked, or whose files differ from the pinned ones.
    #[error("cannot unpack {file}: {why}")]
    BadWheel {
        /// The wheel's file name.
        file: String,
        /// Reason.
        why: String,
    },
    /// A cancellation by the user.
    #[error("canceled while {what}; nothing was changed")]
    Cancelled {
        /// The task.
        what: String,
    },
    /// EnergyPlus is not installed.
    #[error("EnergyPlus is missing or damaged in {cache}: {ADVICE}")]
    NotInstalled {
        /// The cache folder.
        cache: PathBuf,
    },
    /// A value of `B2B_ENERGYPLUS` without EnergyPlus.
    #[error(
        "B2B_ENERGYPLUS is {path}, which does not contain {looked_for}: set it to the folder of an EnergyPlus \
         installation or to that library, or unset it to use the packaged EnergyPlus"
    )]
    NoLibrary {
        /// The value of the variable.
        path: PathBuf,
        /// The library's file name on this platform.
        looked_for: &'static str,
    },
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
}

/// Remedies for a package that is missing and cannot be downloaded.
const ADVICE: &str = "connect to the network and run `b2b setup`; or copy the cache folder of another machine and set \
                      B2B_CACHE to the copy; or, for EnergyPlus alone, set B2B_ENERGYPLUS to an installation";

/// A result of the installation.
pub type Result<T> = std::result::Result<T, Error>;

/// Adds the path to an I/O error.
pub(super) fn at(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.into();
    move |source| Error::Io { path, source }
}
