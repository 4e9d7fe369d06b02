//! Errors of learners, collectors and training.

use std::path::{Path, PathBuf};

/// The result of an operation of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An invalid value in a configuration.
    #[error("`{name}` is {value}; {remedy}")]
    Config {
        /// Name of the field.
        name: &'static str,
        /// The value.
        value: String,
        /// The values that are allowed.
        remedy: &'static str,
    },
    /// An array of a rollout whose length does not match the counts and widths.
    #[error("`{name}` of the rollout has {length} values; expected {expected}")]
    Rollout {
        /// Name of the array.
        name: &'static str,
        /// Its length.
        length: usize,
        /// The expected length.
        expected: usize,
    },
    /// A step in a list of a rollout that is outside the rollout, or out of order.
    #[error(
        "`{name}` of the rollout has step {step} of environment {environment}, which is outside the rollout or out of \
         order"
    )]
    Step {
        /// Name of the list.
        name: &'static str,
        /// The environment.
        environment: usize,
        /// The step.
        step: usize,
    },
    /// Losses or gradients that were not finite in several updates in a row.
    #[error(
        "losses or gradients were not finite in {updates} updates in a row; lower the learning rate, or check that \
         observations and rewards are finite and scaled"
    )]
    NotFinite {
        /// Number of updates.
        updates: u64,
    },
    /// A tensor that is missing from a saved state, or has another type or shape.
    #[error(
        "the saved state has no tensor `{name}` of {expected}; was it saved with the same configuration?"
    )]
    Tensor {
        /// Name of the tensor.
        name: String,
        /// Expected type and number of values.
        expected: String,
    },
    /// Bytes that are not a saved state.
    #[error("not a saved state: {0}")]
    State(String),
    /// An error of a collector.
    #[error("cannot collect steps: {0}")]
    Collect(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// Several episodes of one environment in a row that were lost.
    #[error("{count} episodes in a row were lost; the last: {why}")]
    LostEpisodes {
        /// Number of episodes.
        count: u32,
        /// Why the last was lost.
        why: String,
    },
    /// A configuration file that cannot be used.
    #[error("{path}: {why}")]
    ConfigFile {
        /// The file.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// A configuration, a dataset or a folder that is not valid.
    #[error("{0}")]
    Invalid(String),
    /// A run's folder that cannot be resumed, or that belongs to another run.
    #[error("cannot resume {path}: {why}")]
    Resume {
        /// The folder.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// The run was interrupted; what was learned up to the last checkpoint is kept.
    #[error("interrupted")]
    Interrupted,
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// An error of an environment.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
    /// An error of an agent.
    #[error(transparent)]
    Agent(#[from] b2b_agent::Error),
    /// An error of an evaluation.
    #[error(transparent)]
    Evaluation(Box<b2b_evaluate::Error>),
    /// A building that cannot be generated or found.
    #[error(transparent)]
    Building(Box<b2b_dataset::Error>),
}

impl From<b2b_evaluate::Error> for Error {
    fn from(error: b2b_evaluate::Error) -> Self {
        match error {
            b2b_evaluate::Error::Interrupted => Self::Interrupted,
            error => Self::Evaluation(Box::new(error)),
        }
    }
}

impl From<b2b_dataset::Error> for Error {
    fn from(error: b2b_dataset::Error) -> Self {
        Self::Building(Box::new(error))
    }
}

/// Adds the path to an error of the operating system.
pub(crate) fn at(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    move |source| Error::Io { path: path.to_owned(), source }
}

impl Error {
    /// Returns the error of a configuration whose field `name` has this value.
    pub(crate) fn config(name: &'static str, value: impl ToString, remedy: &'static str) -> Self {
        Self::Config { name, value: value.to_string(), remedy }
    }
}
