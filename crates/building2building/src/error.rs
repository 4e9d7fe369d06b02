//! Errors of all crates as one type.

/// Result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of any of the crates.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[error(transparent)]
pub enum Error {
    /// Downloading or finding the engine or a weather file.
    Install(Box<b2b_energyplus::install::Error>),
    /// The engine.
    Engine(Box<b2b_energyplus::Error>),
    /// Places and weather.
    Climate(Box<b2b_climate::Error>),
    /// Building models and their preparation.
    Building(Box<b2b_building::Error>),
    /// The dataset, and names of buildings.
    Dataset(Box<b2b_dataset::Error>),
    /// Environments and tasks.
    Environment(Box<b2b_env::Error>),
    /// Controllers.
    Control(Box<b2b_control::Error>),
    /// Evaluation and benchmark problems.
    Evaluation(Box<b2b_evaluate::Error>),
    /// Trained agents.
    Agent(Box<b2b_agent::Error>),
    /// Training.
    Training(Box<b2b_learn::Error>),
    /// The system.
    System(#[from] std::io::Error),
}

/// Boxes the errors of a crate, so that an error is small to return.
macro_rules! boxed {
    ($($variant:ident: $error:ty),*) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::$variant(Box::new(error))
            }
        }
    )*};
}

boxed!(
    Install: b2b_energyplus::install::Error,
    Engine: b2b_energyplus::Error,
    Climate: b2b_climate::Error,
    Building: b2b_building::Error,
    Dataset: b2b_dataset::Error,
    Environment: b2b_env::Error,
    Control: b2b_control::Error
);
boxed!(Evaluation: b2b_evaluate::Error, Agent: b2b_agent::Error, Training: b2b_learn::Error);
