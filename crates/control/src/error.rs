//! What can go wrong with controllers.

use std::path::PathBuf;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A parameter of the reactive controllers that cannot be.
    #[error("`{name}` is {value}, and must be a number from {low} to {high} {unit}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// A file that holds no parameters.
    #[error("{path} has no parameters of reactive controllers: {why}")]
    ParameterFile {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        why: String,
    },
    /// A file of evaluations that belongs to another tuning, or was changed.
    #[error("{path} is of another tuning: {why}; remove it, or give another folder")]
    OtherTuning {
        /// The file.
        path: PathBuf,
        /// What is different.
        why: String,
    },
    /// Too few buildings.
    #[error("{class} has {there} training buildings: {asked} were asked for")]
    TooFewBuildings {
        /// The class.
        class: String,
        /// How many there are.
        there: usize,
        /// How many were asked for.
        asked: usize,
    },
    /// An episode that was lost.
    #[error("an episode of {building} was lost: {why}")]
    Lost {
        /// Name of the building.
        building: String,
        /// Why.
        why: String,
    },
    /// The search failed.
    #[error("the search for parameters failed: {0}")]
    Search(String),
    /// A building could not be made.
    #[error(transparent)]
    Building(Box<b2b_dataset::Error>),
    /// An environment failed.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
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

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
