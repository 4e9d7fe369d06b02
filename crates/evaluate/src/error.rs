//! The errors of this crate.

use std::path::{Path, PathBuf};

use b2b_base::suggestion::{did_you_mean, nearest};

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
        "unknown policy `{text}`{}; expected {}, the folder of an agent or an ONNX file (.onnx)",
        remedy(text),
        b2b_control::KINDS.map(b2b_control::Kind::name).join(", ")
    )]
    UnknownPolicy {
        /// The name given.
        text: String,
    },
    /// Noise on a policy without actuators.
    #[error("`{policy}` commands no actuators, so noise would have no effect; remove the noise")]
    NoiseWithoutActuators {
        /// Name of the policy.
        policy: String,
    },
    /// A level of noise that is not from 0 to 2.
    #[error("the level of noise is `{text}`; expected a share of half of each actuator's range, from 0 to 2")]
    NoiseLevel {
        /// The level given.
        text: String,
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
    /// Two model files of one name, by which results tell buildings apart.
    #[error(
        "{first} and {second} are both named `{name}`, by which results tell buildings apart; rename one of them"
    )]
    SameName {
        /// The name.
        name: String,
        /// A file.
        first: String,
        /// Another one.
        second: String,
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
    /// A file whose content is damaged.
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
    /// A table could not be written or read.
    #[error("{path}: {source}")]
    Table {
        /// The file.
        path: PathBuf,
        /// The library's error.
        source: parquet::errors::ParquetError,
    },
    /// An unknown problem.
    #[error("unknown problem `{text}`{}; `b2b benchmark list` lists all", did_you_mean(near))]
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
    /// The evaluation was interrupted. Finished episodes are kept.
    #[error("interrupted")]
    Interrupted,
    /// A building could not be found or prepared.
    #[error(transparent)]
    Building(Box<b2b_dataset::Error>),
    /// An environment failed.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
    /// A controller that cannot be made.
    #[error(transparent)]
    Control(Box<b2b_control::Error>),
    /// An agent that cannot be read, or cannot act in a building.
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
    /// An error of a policy that another crate implements.
    #[error(transparent)]
    Policy(Box<dyn std::error::Error + Send + Sync>),
}

impl From<b2b_dataset::Error> for Error {
    fn from(error: b2b_dataset::Error) -> Self {
        Self::Building(Box::new(error))
    }
}

impl From<b2b_control::Error> for Error {
    fn from(error: b2b_control::Error) -> Self {
        Self::Control(Box::new(error))
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

/// Returns what to do about an unknown policy: compare policies if several are named, use the nearest name if one is
/// similar; otherwise empty.
fn remedy(policy: &str) -> String {
    let known = || b2b_control::KINDS.into_iter().map(b2b_control::Kind::name);
    let mut words = policy.split([' ', ',']).filter(|word| !word.is_empty());
    if words.clone().count() > 1 && words.all(|word| known().any(|name| name == word)) {
        return ", an evaluation has one policy: evaluate each in its own folder, then `b2b evaluate compare`".into();
    }
    did_you_mean(&nearest(policy, known()))
}
