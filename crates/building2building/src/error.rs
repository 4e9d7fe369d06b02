//! Errors of all crates as one type.

/// Result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of any of the crates.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[error(transparent)]
pub enum Error {
    /// Downloading or finding the engine or a weather file.
    Install(#[from] b2b_energyplus::install::Error),
    /// The engine.
    Engine(#[from] b2b_energyplus::Error),
    /// Places and weather.
    Climate(#[from] b2b_climate::Error),
    /// Building models and their preparation.
    Building(#[from] b2b_building::Error),
    /// The dataset, and names of buildings.
    Dataset(#[from] b2b_dataset::Error),
    /// Environments and tasks.
    Environment(#[from] b2b_env::Error),
    /// Controllers.
    Control(#[from] b2b_control::Error),
    /// Evaluation and benchmark problems.
    #[cfg(target_os = "linux")]
    Evaluation(#[from] b2b_benchmark::Error),
    /// The system.
    System(#[from] std::io::Error),
}
