//! Errors of agents.

use std::path::{Path, PathBuf};

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An unknown form of observations.
    #[error("unknown observation `{text}`; expected raw, roles or features")]
    UnknownObservation {
        /// The text.
        text: String,
    },
    /// A folder without an agent.
    #[error(
        "{path} is not the folder of an agent: {why}; expected a folder written by `b2b train`, with agent.json and weights.safetensors"
    )]
    NotAnAgent {
        /// The folder.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// An agent whose files are damaged or inconsistent.
    #[error("the agent in {path} is damaged: {why}; train it again, or restore its files")]
    Damaged {
        /// The folder.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// A building whose observation or actuators differ from the agent's.
    #[error("the agent {agent} cannot control {building}: {why}; it was trained on {trained_on}")]
    OtherBuilding {
        /// Folder of the agent.
        agent: String,
        /// Name of the building.
        building: String,
        /// The first difference found.
        why: String,
        /// Its training buildings.
        trained_on: String,
    },
    /// A graph agent whose nodes have other features or actions than here.
    #[error("the agent {agent} was saved by another version, whose nodes differ: {why}; train it again")]
    OtherVersion {
        /// Folder of the agent.
        agent: String,
        /// The first difference found.
        why: String,
    },
    /// A building with actuators at a node type that is unknown to a graph agent with direct actions.
    #[error(
        "the agent {agent} was not trained with the node type `{node_type}` of `{node}` in {building}, only with {known}; train it \
         with a building that has one, or as corrections of the reactive controllers"
    )]
    UnknownNodeType {
        /// Folder of the agent.
        agent: String,
        /// Name of the building.
        building: String,
        /// The node.
        node: String,
        /// Its type.
        node_type: &'static str,
        /// The node types that the agent was trained with.
        known: String,
    },
    /// A building in which an agent has no actions.
    #[error(
        "an agent has nothing to set in {building}: its only points are setpoints and start times, which `acting.setpoints` = \
         false leaves to guideline36; expected `acting.setpoints` = true"
    )]
    NothingToSet {
        /// Name of the building.
        building: String,
    },
    /// Supervision in a task without comfort bands.
    #[error(
        "supervision shifts guideline36, the controller of operation, and the task is {task}; choose `operate`"
    )]
    NotOperation {
        /// The task.
        task: String,
    },
    /// A building whose graph cannot be made.
    #[error("cannot build the graph of {building}: {source}")]
    Graph {
        /// Name of the building.
        building: String,
        /// Reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// An agent whose actions depend on more than the current observation.
    #[error(
        "cannot export the agent {agent} to ONNX: {why}; expected one trained with `--direct` and the observation raw or roles"
    )]
    NotExportable {
        /// Name of the agent.
        agent: String,
        /// Reason.
        why: &'static str,
    },
    /// A building whose attributes cannot be determined.
    #[error("the attributes of {building} cannot be determined: {source}; train without `attributes`")]
    Attributes {
        /// The building.
        building: String,
        /// Reason.
        source: Box<b2b_building::Error>,
    },
    /// A weather file that cannot be read.
    #[error(transparent)]
    Weather(Box<b2b_climate::Error>),
    /// An agent that supervises from rules that have changed.
    #[error(
        "the agent in {path} was trained from the rules {trained}, and those of this version are {here}; train it again"
    )]
    OtherRules {
        /// The folder.
        path: PathBuf,
        /// Identity of the rules in training.
        trained: String,
        /// Identity of this version's.
        here: String,
    },
    /// A controller that cannot be made.
    #[error(transparent)]
    Control(Box<b2b_control::Error>),
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
}

/// Adds the path to an error of the operating system.
pub(crate) fn at(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    move |source| Error::Io { path: path.to_owned(), source }
}

impl From<b2b_control::Error> for Error {
    fn from(error: b2b_control::Error) -> Self {
        Self::Control(Box::new(error))
    }
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
