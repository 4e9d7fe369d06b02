//! What can go wrong in an evaluation.

use std::path::{Path, PathBuf};

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that holds no policy.
    #[error("{path} is no ONNX model: {why}")]
    NoOnnx {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// An ONNX model that is no policy.
    #[error(
        "{path} is no policy: {why}; a policy takes one float32 array [1, observation] and gives one [1, action]"
    )]
    NoPolicy {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// A policy for other observations.
    #[error(
        "{policy} takes {given} numbers, and an observation of {building} under task {task} has {}: {}",
        slots.len(), slots.join(", ")
    )]
    ObservationShape {
        /// The policy.
        policy: String,
        /// Numbers that it takes.
        given: usize,
        /// The building.
        building: String,
        /// The task.
        task: String,
        /// What an observation of the building is.
        slots: Vec<String>,
    },
    /// A policy for other actions.
    #[error("{policy} gives {given} numbers, and an action of {building} has {}: {}", slots.len(), slots.join(", "))]
    ActionShape {
        /// The policy.
        policy: String,
        /// Numbers that it gives.
        given: usize,
        /// The building.
        building: String,
        /// What an action of the building is.
        slots: Vec<String>,
    },
    /// A name that is no policy.
    #[error("there is no policy `{text}`: give reactive, random, constant, planner, or an ONNX file (.onnx)")]
    UnknownPolicy {
        /// What was given.
        text: String,
    },
    /// A name that is no problem.
    #[error("there is no problem `{text}`{}; `b2b benchmark list` has all", if near.is_empty() { String::new() } else { format!(": did you mean {near}?") })]
    UnknownProblem {
        /// What was given.
        text: String,
        /// Names that are near.
        near: String,
    },
    /// A file that is no problem.
    #[error("{path} is no problem: {why}")]
    ProblemFile {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        why: String,
    },
    /// A problem that cannot be.
    #[error("problem {name}: {why}")]
    Problem {
        /// Its name.
        name: String,
        /// What is wrong.
        why: String,
    },
    /// A building that must not be trained on.
    #[error("{building} is not to train on in {problem}: {why}")]
    ForTests {
        /// The problem.
        problem: String,
        /// The building.
        building: String,
        /// Why.
        why: String,
    },
    /// A benchmark run that has not ended.
    #[error("{folder} is unfinished: the `b2b benchmark run` that it is of goes on with it")]
    Unfinished {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder without a result.
    #[error("{folder} holds no result of `b2b benchmark run`")]
    NoResult {
        /// The folder.
        folder: PathBuf,
    },
    /// A result that was changed after it was written.
    #[error("{folder} is not as it was written: {what}")]
    Forged {
        /// The folder.
        folder: PathBuf,
        /// What is not.
        what: String,
    },
    /// A folder of another evaluation.
    #[error("{folder} holds another evaluation: {differences}; give another folder, or remove it")]
    OtherEvaluation {
        /// The folder.
        folder: PathBuf,
        /// In what it differs.
        differences: String,
    },
    /// A folder that another process is at work in.
    #[error("{folder} is in use by another evaluation that is running")]
    Busy {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder of other files.
    #[error("{folder} is not empty and holds no evaluation: give a new folder")]
    Foreign {
        /// The folder.
        folder: PathBuf,
    },
    /// A file that is not what it was written as.
    #[error("{path} is damaged: {why}; remove it, and what it held is computed again")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// No reactive episode to compare with.
    #[error("{building}, {task}, {period}: there is no baseline: {why}")]
    NoBaseline {
        /// The building.
        building: String,
        /// The task.
        task: String,
        /// The run period.
        period: String,
        /// Why.
        why: String,
    },
    /// An evaluation of nothing.
    #[error("there is no episode to run")]
    NoEpisode,
    /// A table cannot be written.
    #[error("{path}: {source}")]
    Table {
        /// The file.
        path: PathBuf,
        /// What was said.
        source: parquet::errors::ParquetError,
    },
    /// Somebody asked to stop. What was finished is kept.
    #[error("interrupted")]
    Interrupted,
    /// A building could not be found or prepared.
    #[error(transparent)]
    Building(Box<b2b_dataset::Error>),
    /// An environment failed.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
    /// The cache folder is not known.
    #[error(transparent)]
    Install(#[from] b2b_energyplus::install::Error),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
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

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Names the file of an error of the system.
pub(crate) fn at(path: &Path) -> impl Fn(std::io::Error) -> Error {
    move |source| Error::Io { path: path.to_owned(), source }
}
