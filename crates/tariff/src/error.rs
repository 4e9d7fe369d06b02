//! Errors of tariffs and emission profiles.

use b2b_base::suggestion::did_you_mean;

/// The result of an operation of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An unknown tariff or emission profile.
    #[error("unknown {what} `{name}`{}; expected {known}, or the path of a TOML file", did_you_mean(near))]
    Unknown {
        /// What was looked for: `tariff` or `emission profile`.
        what: &'static str,
        /// The name given.
        name: String,
        /// The most similar name, quoted; empty if none is similar.
        near: String,
        /// The known names.
        known: String,
    },
    /// A file that cannot be read.
    #[error("{file}: {source}")]
    Io {
        /// The file.
        file: String,
        /// The cause.
        source: std::io::Error,
    },
    /// A file that is not a valid tariff or emission profile.
    #[error("{file}:{line}: {why}")]
    File {
        /// The file, or the name of a shipped one.
        file: String,
        /// The line, from 1.
        line: usize,
        /// Reason and remedy.
        why: String,
    },
    /// Inputs that a tariff needs in addition to its file, and that are missing or have the wrong length.
    #[error("the tariff `{tariff}` {why}")]
    Inputs {
        /// Name of the tariff.
        tariff: String,
        /// Reason and remedy.
        why: String,
    },
}

/// A fault at a position in a file.
#[derive(Debug)]
pub(crate) struct Fault {
    /// Where it begins, in bytes from the start of the file.
    offset: usize,
    why: String,
}

impl Fault {
    /// Returns a fault that begins at an offset in bytes.
    pub(crate) fn at(offset: usize, why: impl Into<String>) -> Self {
        Self { offset, why: why.into() }
    }

    /// Returns the error for a file, with the line of the fault in its text.
    pub(crate) fn of(self, file: &str, text: &str) -> Error {
        let before = &text.as_bytes()[..self.offset.min(text.len())];
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        Error::File { file: file.to_owned(), line, why: self.why }
    }
}

impl From<toml::de::Error> for Fault {
    fn from(error: toml::de::Error) -> Self {
        let why = b2b_base::suggestion::with_suggestion(error.message());
        Self::at(error.span().map_or(0, |span| span.start), why)
    }
}

/// Reads a file.
pub(crate) fn read(path: &std::path::Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|source| Error::Io { file: path.display().to_string(), source })
}
