//! The errors of this crate.

use std::path::{Path, PathBuf};

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that is not an ONNX model.
    #[error("{path} is not a valid ONNX model: {why}")]
    InvalidOnnx {
        /// The file.
        path: PathBuf,
        /// The fault.
        why: String,
    },
    /// An ONNX model that is not a policy.
    #[error(
        "{path} is not a policy: {why}; a policy takes one float32 array [1, observation] and returns one [1, action]"
    )]
    InvalidPolicy {
        /// The file.
        path: PathBuf,
        /// The fault.
        why: String,
    },
    /// A policy for observations of another length.
    #[error(
        "{policy} takes {given} values, but an observation of {building} under task {task} has {}: {}",
        slots.len(), slots.join(", ")
    )]
    ObservationShape {
        /// The policy.
        policy: String,
        /// Length of its input.
        given: usize,
        /// The building.
        building: String,
        /// The task.
        task: String,
        /// Names of the values in an observation of the building.
        slots: Vec<String>,
    },
    /// A policy for actions of another length.
    #[error("{policy} returns {given} values, but an action of {building} has {}: {}", slots.len(), slots.join(", "))]
    ActionShape {
        /// The policy.
        policy: String,
        /// Length of its output.
        given: usize,
        /// The building.
        building: String,
        /// Names of the building's actuators.
        slots: Vec<String>,
    },
    /// An unknown policy.
    #[error(
        "unknown policy `{text}`; expected reactive, random, constant, planner, the folder of an agent or an ONNX file (.onnx)"
    )]
    UnknownPolicy {
        /// The name given.
        text: String,
    },
    /// A policy that is a program of the author of a result.
    #[error("the policy `{name}` is a program of its author, which the result does not contain")]
    ExternalPolicy {
        /// Its name.
        name: String,
    },
    /// An unknown problem.
    #[error("unknown problem `{text}`{}; `b2b benchmark list` lists all", if near.is_empty() { String::new() } else { format!(", did you mean {near}?") })]
    UnknownProblem {
        /// The name given.
        text: String,
        /// Similar names.
        near: String,
    },
    /// A file that is not a problem.
    #[error("{path} is not a valid problem: {why}")]
    ProblemFile {
        /// The file.
        path: PathBuf,
        /// The fault.
        why: String,
    },
    /// An invalid problem, or a policy that violates its protocol.
    #[error("problem {name}: {why}")]
    Problem {
        /// Its name.
        name: String,
        /// The fault.
        why: String,
    },
    /// A building that must not be trained on.
    #[error("{building} is not a training building of {problem}: {why}")]
    NotForTraining {
        /// The problem.
        problem: String,
        /// The building.
        building: String,
        /// The reason.
        why: String,
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
    #[error(
        "{path} changed while its episodes ran, so the result would not be that of the file; run it again"
    )]
    ChangedPolicy {
        /// The file or folder.
        path: PathBuf,
    },
    /// A folder of a different evaluation.
    #[error(
        "{folder} contains a different evaluation: {differences}; choose another folder or remove this one"
    )]
    OtherEvaluation {
        /// The folder.
        folder: PathBuf,
        /// The differences.
        differences: String,
    },
    /// Evaluations that cannot be compared.
    #[error("cannot compare `{name}`: {why}; evaluate all policies with the same arguments")]
    OtherEpisodes {
        /// Name of the evaluation.
        name: String,
        /// The difference.
        why: String,
    },
    /// A folder that another process is writing to.
    #[error("{folder} is in use by another running evaluation; wait for it, or choose another folder")]
    Busy {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder of unrelated files.
    #[error("{folder} is not empty and contains no evaluation; choose a new folder")]
    UnrelatedFiles {
        /// The folder.
        folder: PathBuf,
    },
    /// A file that cannot be parsed.
    #[error("{path} is damaged: {why}; remove it to recompute it")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The fault.
        why: String,
    },
    /// A lost baseline episode.
    #[error("no baseline for {building}, {task}, {period}: {why}")]
    NoBaseline {
        /// The building.
        building: String,
        /// The task.
        task: String,
        /// The run period.
        period: String,
        /// The reason.
        why: String,
    },
    /// An empty list of episodes.
    #[error("the list of episodes is empty; select at least one building, task, run period and seed")]
    NoEpisode,
    /// A table could not be written.
    #[error("{path}: {source}")]
    Table {
        /// The file.
        path: PathBuf,
        /// The library's error.
        source: parquet::errors::ParquetError,
    },
    /// The evaluation was interrupted. Finished episodes are kept.
    #[error("interrupted")]
    Interrupted,
    /// A building could not be found or prepared.
    #[error(transparent)]
    Building(Box<b2b_dataset::Error>),
    /// An environment failed.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
    /// An agent that cannot be read, or not act in a building.
    #[error(transparent)]
    Agent(#[from] b2b_agent::Error),
    /// The cache folder is unknown.
    #[error(transparent)]
    Install(#[from] b2b_energyplus::install::Error),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}

impl From<b2b_dataset::Error> for Error {
    fn from(error: b2b_dataset::Error) -> Self {
        Self::Building(Box::new(error))
    }
}

impl From<b2b_building::Error> for Error {
    fn from(error: b2b_building::Error) -> Self {
        b2b_dataset::Error::from(error).into()
    }
}

impl From<b2b_climate::Error> for Error {
    fn from(error: b2b_climate::Error) -> Self {
        b2b_dataset::Error::from(error).into()
    }
}

/// A result with this crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Returns a function that adds the path to a system error.
pub(crate) fn at(path: &Path) -> impl Fn(std::io::Error) -> Error {
    move |source| Error::Io { path: path.to_owned(), source }
}
