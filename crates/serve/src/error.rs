//! Errors before the first request.

/// Why a building cannot be served.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A task with targets.
    #[error(
        "the task `{task}` has targets; BOPTEST's indicators need bands: use operate or operate:21-24/15.6-28"
    )]
    NoBands {
        /// The task.
        task: String,
    },
    /// A task with a tariff, prices of its own, a preview or faults.
    #[error("the task `{task}` has {what}; {remedy}")]
    TaskPart {
        /// The task.
        task: String,
        /// The part that cannot be served.
        what: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A controller that plans whole episodes.
    #[error(
        "the controller {name} plans whole episodes; use one that acts step by step, such as guideline36"
    )]
    Plans {
        /// Its name.
        name: &'static str,
    },
    /// A building whose year has a 29 February.
    #[error("the weather file has a 29 February; BOPTEST's year has 365 days: use weather of a common year")]
    LeapDay,
    /// The server cannot run.
    #[error("cannot {what}: {source}")]
    Io {
        /// The operation that failed.
        what: &'static str,
        /// Reason.
        source: std::io::Error,
    },
    /// From the environment.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
    /// From the controller.
    #[error(transparent)]
    Control(#[from] b2b_control::Error),
    /// From the weather file.
    #[error(transparent)]
    Climate(#[from] b2b_climate::Error),
    /// From a tariff.
    #[error(transparent)]
    Tariff(#[from] b2b_tariff::Error),
}

/// A result.
pub type Result<T> = std::result::Result<T, Error>;
