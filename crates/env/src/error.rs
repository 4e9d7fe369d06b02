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
    /// The system refused what worker processes need.
    #[error("cannot get {what}: {source}")]
    Pool {
        /// What was asked for.
        what: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// A building that cannot be made an environment.
    #[error("{name} cannot be made an environment: {why}")]
    Template {
        /// Name of the building.
        name: String,
        /// Why.
        why: String,
    },
    /// An episode or a template whose process died, hung or failed.
    #[error("{what} was lost: {why}")]
    Lost {
        /// What was lost.
        what: String,
        /// Why.
        why: String,
    },
    /// An episode that is asked for a step while it is busy with another.
    #[error("the episode is busy with another step: receive that first, or reset")]
    Busy,
    /// A building with more actuators or observation slots than there is room for.
    #[error("{name} has {width} {what}, and there is room for {most}")]
    TooWide {
        /// Name of the building.
        name: String,
        /// What it has too many of.
        what: &'static str,
        /// How many.
        width: usize,
        /// How many there may be.
        most: usize,
    },
    /// A snapshot of another building or episode.
    #[error(
        "the snapshot is of another episode ({taken}) than this one ({here}): building, weather, period and task must be the same"
    )]
    OtherSnapshot {
        /// Building of the snapshot.
        taken: String,
        /// Building of the environment.
        here: String,
    },
    /// A population without buildings.
    #[error("there is no building to draw from")]
    NoBuilding,
    /// A vector environment of none.
    #[error("a vector environment needs at least one environment, not 0")]
    NoEnvironment,
    /// Windows that do not fit their run period.
    #[error("windows of {least} to {most} days cannot be cut from {whole} days")]
    Window {
        /// Least days.
        least: u32,
        /// Most days.
        most: u32,
        /// Days of the run period.
        whole: u32,
    },
    /// Waiting was interrupted.
    #[error("interrupted")]
    Interrupted,
    /// A slot of the observation or the action that has no place in the morphology.
    #[error("`{slot}` belongs to no node of the morphology of {building}: its node type has no such slot")]
    SlotWithoutNode {
        /// Name of the slot.
        slot: String,
        /// Name of the building of the morphology.
        building: String,
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
    /// A building that cannot be made.
    #[error(transparent)]
    Building(Box<b2b_building::Error>),
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

impl From<b2b_building::Error> for Error {
    fn from(error: b2b_building::Error) -> Self {
        Self::Building(Box::new(error))
    }
}
