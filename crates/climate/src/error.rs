//! Errors of places and weather files.

use std::path::PathBuf;

use b2b_base::suggestion::did_you_mean;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that is not a valid weather file.
    #[error("{path}: {why}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// A place without a known weather file.
    #[error(
        "unknown place `{name}`{}; expected one of {}; other places are given by their EPW file, as weather",
        did_you_mean(near.unwrap_or_default()),
        known.join(", ")
    )]
    UnknownPlace {
        /// The requested name.
        name: String,
        /// The most similar known place.
        near: Option<&'static str>,
        /// Every known place.
        known: Vec<&'static str>,
    },
    /// A weather package could not be installed.
    #[error(transparent)]
    Install(#[from] b2b_energyplus::install::Error),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
