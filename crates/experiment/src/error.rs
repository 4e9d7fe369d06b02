//! Errors of experiments.

use std::path::{Path, PathBuf};

use b2b_base::suggestion::did_you_mean;

/// The result of an operation of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An unknown experiment.
    #[error(
        "unknown experiment `{name}`{}; expected a name from `b2b experiment list` or the path of a TOML file",
        did_you_mean(near)
    )]
    Unknown {
        /// The name given.
        name: String,
        /// The most similar name.
        near: String,
    },
    /// A budget that an experiment does not have.
    #[error("the experiment {experiment} has no budget `{name}`{}; expected {known}", did_you_mean(near))]
    UnknownBudget {
        /// The name given.
        name: String,
        /// The experiment.
        experiment: String,
        /// The most similar name.
        near: String,
        /// The known names.
        known: String,
    },
    /// A definition that is not valid.
    #[error("the experiment {path} is not valid: {why}")]
    Definition {
        /// The file.
        path: String,
        /// The fault.
        why: String,
    },
    /// A folder of another experiment or budget.
    #[error("{path} has the results of {other}; choose another folder for {experiment}")]
    OtherExperiment {
        /// The folder.
        path: PathBuf,
        /// The experiment whose results it has.
        other: String,
        /// What was to run.
        experiment: String,
    },
    /// The result of a job with different actions.
    #[error(
        "{path} has a result of the job {job} with other options or episodes than the experiment has now; choose another folder, or \
         remove that result"
    )]
    OtherJob {
        /// The folder.
        path: PathBuf,
        /// Key of the job.
        job: String,
    },
    /// A result that another version of the program made.
    #[error(
        "{path} has a result of the job {job} from another version: {differences}; choose another folder, or remove that \
         result"
    )]
    OtherVersion {
        /// The folder.
        path: PathBuf,
        /// Key of the job.
        job: String,
        /// What differs.
        differences: String,
    },
    /// A folder without results.
    #[error("{path} has no results of an experiment; `b2b experiment run` writes them")]
    NoResults {
        /// The folder.
        path: PathBuf,
    },
    /// A folder without agents and controllers.
    #[error(
        "{path} has no agents to check and no results of controllers; expected jobs/AGENT/.../agent with agent.json and weights.safetensors"
    )]
    NoAgents {
        /// The folder.
        path: PathBuf,
    },
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
    /// An error of an agent.
    #[error(transparent)]
    Agent(#[from] b2b_agent::Error),
    /// An error of the benchmark.
    #[error(transparent)]
    Benchmark(#[from] b2b_benchmark::Error),
    /// An error of an evaluation.
    #[error(transparent)]
    Evaluation(Box<b2b_evaluate::Error>),
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
}

impl From<b2b_evaluate::Error> for Error {
    fn from(error: b2b_evaluate::Error) -> Self {
        Self::Evaluation(Box::new(error))
    }
}

/// Adds the path to an error of the operating system.
pub(crate) fn at(path: &Path) -> impl FnOnce(std::io::Error) -> Error + '_ {
    |source| Error::Io { path: path.to_owned(), source }
}
