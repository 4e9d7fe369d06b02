//! What can go wrong with a building model.

use std::path::PathBuf;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that is not what its name says.
    #[error("{path}: {why}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        why: String,
    },
    /// An object that the model refers to, or that an edit needs, is not there.
    #[error("the model has no {class} named `{name}`")]
    MissingObject {
        /// EnergyPlus class.
        class: String,
        /// Object name.
        name: String,
    },
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The engine refused a model or stopped.
    #[error(transparent)]
    Engine(#[from] b2b_energyplus::Error),
    /// The engine's table of sizes could not be read.
    #[error("the sizes in {path} cannot be read: {source}")]
    SizeTable {
        /// The engine's SQLite output.
        path: PathBuf,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// Fields that the model leaves to the engine to size and for which the engine gave no size.
    #[error("the engine gives no size for:\n  {}\nGive each a number in the model.", fields.join("\n  "))]
    Unsized {
        /// Each field as class, object and field.
        fields: Vec<String>,
    },
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
