//! What can go wrong in an environment.

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An action is not a number.
    #[error("the action for `{actuator}` is {value}: give a finite number between {low} and {high} {unit}")]
    ActionNotFinite {
        /// Name of the actuator.
        actuator: String,
        /// What was given.
        value: f64,
        /// Lowest value accepted.
        low: f64,
        /// Highest value accepted.
        high: f64,
        /// Unit of the bounds.
        unit: &'static str,
    },
    /// An action of the wrong length.
    #[error("the action has {given} values, but the building has {expected} actuators")]
    ActionLength {
        /// How many values were given.
        given: usize,
        /// How many there must be.
        expected: usize,
    },
    /// A step without an episode in progress.
    #[error("no episode is in progress: call reset before step")]
    NotReset,
    /// A number of steps per hour that the engine does not take.
    #[error("{0} steps per hour is not possible: give 1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30 or 60")]
    StepsPerHour(u32),
    /// The engine took another number of steps than the run period has.
    #[error("the engine ended the episode after {done} steps instead of {expected}")]
    EpisodeLength {
        /// Steps done.
        done: usize,
        /// Steps of the run period.
        expected: usize,
    },
    /// A value that is not a number came out of the engine.
    #[error("the engine gave {value} for `{slot}` at step {step}")]
    ObservationNotFinite {
        /// Name of the observation slot.
        slot: String,
        /// What it was.
        value: f64,
        /// The step, from 1.
        step: usize,
    },
    /// Text that is no task.
    #[error(
        "there is no task `{text}`: give constant, occupancy or random, with +energyW for a weight W, for example \
         occupancy+energy0.5, or the path of a JSON file"
    )]
    UnknownTask {
        /// The text.
        text: String,
    },
    /// A file that holds no task.
    #[error("{path} is no task: {why}")]
    TaskFile {
        /// The file.
        path: std::path::PathBuf,
        /// What is wrong in it.
        why: String,
    },
    /// A value of a task that cannot be.
    #[error("`{name}` of the task is {value}, and must be a number from {low} to {high}")]
    TaskValue {
        /// The field.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
    },
    /// The engine failed, or refused a handle.
    #[error(transparent)]
    Engine(#[from] b2b_energyplus::Error),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: std::path::PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
