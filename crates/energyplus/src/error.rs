//! What can go wrong between the caller and the engine.

use std::path::PathBuf;

use crate::message::Messages;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The shared library is not there, is not EnergyPlus, or lacks a function.
    #[error(
        "{path} cannot be used as the EnergyPlus library: {why}\n\
         Point B2B_ENERGYPLUS at a folder that holds it, or run `b2b setup`."
    )]
    Library {
        /// The file tried.
        path: PathBuf,
        /// What the loader said.
        why: String,
    },
    /// An input file of a run is not there.
    #[error("{what} not found: {path}")]
    MissingFile {
        /// What the file is for.
        what: &'static str,
        /// The path as given.
        path: PathBuf,
    },
    /// A path or a name holds a zero byte, which the engine cannot be given.
    #[error("{text:?} holds a zero byte, which EnergyPlus cannot read")]
    ZeroByte {
        /// The text.
        text: String,
    },
    /// The engine stopped by itself, with its own words.
    #[error("EnergyPlus failed (exit code {code}) on {model}:\n{messages}")]
    Engine {
        /// Exit code of the engine.
        code: i32,
        /// The model it ran.
        model: PathBuf,
        /// What it said.
        messages: Messages,
    },
    /// The model has no such variable, or it was not requested before the start.
    #[error("the model has no variable `{name}` for `{key}` (a variable must be requested before the start)")]
    UnknownVariable {
        /// Variable name.
        name: String,
        /// Key: a zone, a node, an object.
        key: String,
    },
    /// The model has no such meter.
    #[error("the model has no meter `{name}`")]
    UnknownMeter {
        /// Meter name.
        name: String,
    },
    /// The model has no such actuator.
    #[error("the model has no actuator `{component}` / `{control}` for `{key}`")]
    UnknownActuator {
        /// Component type.
        component: String,
        /// Control type.
        control: String,
        /// Key: an object name.
        key: String,
    },
    /// The run is over: there is nothing left to advance.
    #[error("the run period of {model} ended before the requested step")]
    Ended {
        /// The model it ran.
        model: PathBuf,
    },
    /// A file or folder could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A process that cannot be copied because it has more than one thread: a copy would have only one of them, and
    /// hold whatever locks the others held.
    #[error("a simulation can be copied in a process of one thread only, and this one has {threads}")]
    Threads {
        /// How many it has.
        threads: usize,
    },
    /// The system refused to copy the process.
    #[error("the simulation cannot be copied: {0}")]
    Fork(std::io::Error),
    /// No stack for the coroutine.
    #[error("no memory for the engine's stack: {0}")]
    Stack(std::io::Error),
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
