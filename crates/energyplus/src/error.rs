//! Errors of EnergyPlus and of its use.

use std::path::PathBuf;

use crate::message::Messages;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A shared library that is missing, is not EnergyPlus, or lacks a function.
    #[error(
        "cannot load {path} as the EnergyPlus library: {why}\n\
         Set B2B_ENERGYPLUS to the folder of an EnergyPlus installation, or run `b2b setup`."
    )]
    Library {
        /// The file.
        path: PathBuf,
        /// Error of the loader.
        why: String,
    },
    /// An environment variable by which EnergyPlus simulates something else than its model says.
    #[error("the environment variable {name} changes what EnergyPlus simulates; unset it")]
    EnvironmentVariable {
        /// Its name.
        name: &'static str,
    },
    /// Another version of EnergyPlus than results state.
    #[error(
        "{path} is EnergyPlus {version}; this program is for {expected}: point B2B_ENERGYPLUS to that version, or unset it"
    )]
    OtherVersion {
        /// The library.
        path: PathBuf,
        /// Its version.
        version: String,
        /// The version that this program is for.
        expected: &'static str,
    },
    /// An input file of a run that does not exist.
    #[error("{what} not found: {path}")]
    MissingFile {
        /// Kind of file.
        what: &'static str,
        /// The path as given.
        path: PathBuf,
    },
    /// A path or name with a zero byte.
    #[error("{text:?} contains a zero byte, which EnergyPlus cannot read")]
    ZeroByte {
        /// The text.
        text: String,
    },
    /// A run that EnergyPlus terminated.
    #[error("EnergyPlus failed (exit code {code}) on {model}:\n{messages}")]
    Engine {
        /// Exit code of EnergyPlus.
        code: i32,
        /// The model.
        model: PathBuf,
        /// Messages of EnergyPlus.
        messages: Messages,
    },
    /// A process in which EnergyPlus crashed, that failed otherwise, or that took too long and was killed.
    #[error(
        "EnergyPlus {end} while {doing}{last_messages}\n\
         Correct the objects of the model or the lines of the weather file that the messages name, or remove objects until it runs"
    )]
    Process {
        /// The work, with the model.
        doing: String,
        /// How it ended.
        end: String,
        /// Its last messages, one per line, if there are any.
        last_messages: String,
    },
    /// An interrupt while waiting for another process.
    #[error("interrupted")]
    Interrupted,
    /// A variable that the model does not have, or that was not requested before the start.
    #[error(
        "unknown variable `{name}` of `{key}`: the model does not have it, or it was not requested before the start"
    )]
    UnknownVariable {
        /// Variable name.
        name: String,
        /// Key: the name of a zone, node or object.
        key: String,
    },
    /// A meter that the model does not have.
    #[error("unknown meter `{name}`: the model does not have it")]
    UnknownMeter {
        /// Meter name.
        name: String,
    },
    /// An actuator that the model does not have.
    #[error("unknown actuator `{component}` / `{control}` of `{key}`: the model does not have it")]
    UnknownActuator {
        /// Component type.
        component: String,
        /// Control type.
        control: String,
        /// Key: the name of an object.
        key: String,
    },
    /// A run that ended before the requested step.
    #[error("the run period of {model} ended before the requested step")]
    Ended {
        /// The model.
        model: PathBuf,
    },
    /// A file or folder that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A temporary folder that cannot be used.
    #[error(transparent)]
    TemporaryFolder(#[from] b2b_base::scratch::TemporaryFolderError),
    /// A process with several threads, which cannot be copied: the copy would have one thread and every lock.
    #[error("cannot copy a simulation in a process with {threads} threads; expected 1")]
    Threads {
        /// Number of threads.
        threads: usize,
    },
    /// A failed copy of the process.
    #[error("cannot copy the simulation: {0}")]
    Fork(std::io::Error),
    /// A failed allocation of the stack of the coroutine.
    #[error("cannot allocate the stack of EnergyPlus: {0}")]
    Stack(std::io::Error),
}

impl Error {
    /// Describes the work of an [`Error::Process`] in the caller's terms, because the caller knows the name of the
    /// model.
    #[must_use]
    pub fn while_doing(self, doing: impl Into<String>) -> Self {
        match self {
            Self::Process { end, last_messages, .. } => {
                Self::Process { doing: doing.into(), end, last_messages }
            }
            other => other,
        }
    }

    /// Names the model of an [`Error::Engine`] in the terms of its caller, who gave the engine a temporary copy.
    #[must_use]
    pub fn on_model(self, model: impl Into<PathBuf>) -> Self {
        match self {
            Self::Engine { code, messages, .. } => Self::Engine { code, model: model.into(), messages },
            other => other,
        }
    }
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
