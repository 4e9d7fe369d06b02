//! The errors of this crate.

use std::path::{Path, PathBuf};

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A policy in the author's own program.
    #[error("the policy `{name}` is the author's own program, which the result does not contain")]
    ExternalPolicy {
        /// Its name.
        name: String,
    },
    /// An unfinished benchmark run.
    #[error("{folder} is unfinished: run the same `b2b benchmark run` again to resume it")]
    Unfinished {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder without a result.
    #[error("{folder} contains no result of `b2b benchmark run`")]
    NoResult {
        /// The folder.
        folder: PathBuf,
    },
    /// A result that was modified after it was written.
    #[error("{folder} was modified after it was written: {what}")]
    Modified {
        /// The folder.
        folder: PathBuf,
        /// The modification.
        what: String,
    },
    /// A policy whose file changed while its episodes ran.
    #[error("{path} changed while its episodes ran, so the result would not match the file; run it again")]
    ChangedPolicy {
        /// The file or folder.
        path: PathBuf,
    },
    /// An evaluation failed.
    #[error(transparent)]
    Evaluation(Box<b2b_evaluate::Error>),
}

impl From<b2b_evaluate::Error> for Error {
    fn from(error: b2b_evaluate::Error) -> Self {
        Self::Evaluation(Box::new(error))
    }
}

/// Converts the errors that an evaluation may have.
macro_rules! evaluation {
    ($($error:ty),*) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                b2b_evaluate::Error::from(error).into()
            }
        }
    )*};
}

evaluation!(b2b_agent::Error, b2b_building::Error, b2b_dataset::Error, b2b_env::Error);

impl From<Error> for b2b_evaluate::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Evaluation(error) => *error,
            error => Self::Policy(Box::new(error)),
        }
    }
}

/// A result with this crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Returns a function that adds the path to a system error.
pub(crate) fn at(path: &Path) -> impl Fn(std::io::Error) -> Error {
    move |source| b2b_evaluate::Error::Io { path: path.to_owned(), source }.into()
}
