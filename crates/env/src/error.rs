//! Errors of environments.

use crate::terms::Resource;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An action value that is not finite.
    #[error("action for `{actuator}` is {value}; expected a finite number from {low} to {high} {unit}")]
    ActionNotFinite {
        /// Name of the actuator.
        actuator: String,
        /// The given value.
        value: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
        /// Unit of the value and the bounds.
        unit: &'static str,
    },
    /// An action of the wrong length.
    #[error("action has {given} values; expected {expected}")]
    ActionLength {
        /// Number of given values.
        given: usize,
        /// Number of expected values.
        expected: usize,
    },
    /// A step without an episode in progress.
    #[error("no episode is in progress: call reset before step")]
    NotReset,
    /// A number of steps per hour that EnergyPlus does not support.
    #[error("unsupported number of steps per hour {0}; expected 1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30 or 60")]
    StepsPerHour(u32),
    /// A run with fewer or more steps than its run period.
    #[error(
        "the run of EnergyPlus has another length than its run period: {done} steps done, {expected} expected"
    )]
    EpisodeLength {
        /// Completed steps.
        done: usize,
        /// Steps of the run period.
        expected: usize,
    },
    /// An observed value that is not finite.
    #[error("EnergyPlus returned {value} for `{slot}` at step {step}; expected a finite number")]
    ObservationNotFinite {
        /// Name of the observation slot.
        slot: String,
        /// The value.
        value: f64,
        /// The step, from 1; 0 at the reset.
        step: usize,
    },
    /// A system resource that could not be created for a pool of environments.
    #[error("cannot create {what}: {source}")]
    Pool {
        /// The resource.
        what: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A building whose environment cannot be prepared.
    #[error("cannot prepare an environment of {name}: {why}")]
    Template {
        /// Name of the building.
        name: String,
        /// Reason.
        why: String,
    },
    /// An episode or a template whose process died, hung or failed.
    #[error("{what} was lost: {why}")]
    Lost {
        /// What was lost.
        what: String,
        /// Reason.
        why: String,
    },
    /// A step requested while another one is in progress.
    #[error("a step of the episode is still in progress: receive it first, or reset")]
    Busy,
    /// A building with too many actuators or observation slots.
    #[error("{name} has {width} {what}; the maximum is {maximum}")]
    TooWide {
        /// Name of the building.
        name: String,
        /// Kind of value, plural.
        what: &'static str,
        /// Number of values.
        width: usize,
        /// Largest number.
        maximum: usize,
    },
    /// A snapshot of another building, configuration of the episode or set of workers.
    #[error(
        "snapshot of {taken} does not match this environment of {here}: building, run period, weather and task must be equal"
    )]
    OtherSnapshot {
        /// Building of the snapshot.
        taken: String,
        /// Building of the environment.
        here: String,
    },
    /// A sampler without buildings.
    #[error("no buildings to sample from: give at least one")]
    NoBuilding,
    /// A vector environment of size 0.
    #[error("a vector environment needs at least one environment")]
    NoEnvironment,
    /// A weight of a sampler that is negative or not finite, or weights that sum to 0.
    #[error(
        "a weight of the sampler is {0}; expected finite weights of 0 or more, at least one of them above 0"
    )]
    Weight(f64),
    /// Windows of no days, in the wrong order, or longer than the run period.
    #[error(
        "windows of {min_days} to {max_days} days in a run period of {whole} days; expected \
         1 ≤ shortest ≤ longest ≤ {whole}"
    )]
    Window {
        /// Shortest window, days.
        min_days: u32,
        /// Longest window, days.
        max_days: u32,
        /// Length of the run period, days.
        whole: u32,
    },
    /// An interrupt while waiting.
    #[error("interrupted")]
    Interrupted,
    /// A slot of the observation or the action without a node in the morphology.
    #[error("no node in the morphology of {building} has a slot for `{slot}`")]
    SlotWithoutNode {
        /// Name of the slot.
        slot: String,
        /// Name of the building.
        building: String,
    },
    /// A JSON object that is not a valid task.
    #[error("invalid task: {why}")]
    InvalidTask {
        /// Reason.
        why: String,
    },
    /// Text that is not a valid task.
    #[error(
        "unknown task `{text}`{why}; expected operate, optionally followed by a tariff of `b2b list tariffs`, for example \
         operate+tou; constant, occupancy or random, optionally followed by +deadband or +pmv, by a resource with a weight W \
         ({}), for example occupancy+energy0.5, by +free-ventilation, by +presenceH with a time H in hours, and by faults such \
         as +noise0.2, the same in all buildings without +own-faults; or the path of a JSON file",
        Resource::spelled()
    )]
    UnknownTask {
        /// The text.
        text: String,
        /// The part that is wrong or, for a preset of the original Python implementation, its name here.
        why: String,
    },
    /// A file without a valid task.
    #[error("{path} is not a valid task: {why}")]
    TaskFile {
        /// The file.
        path: std::path::PathBuf,
        /// Reason.
        why: String,
    },
    /// A part of a task that needs bands, in a task with targets.
    #[error("`{part}` needs comfort bands; expected a task such as operate+{part}")]
    NeedsBands {
        /// The part.
        part: &'static str,
    },
    /// A field of a task that has no effect with bands.
    #[error("the task's `{field}` has no effect with comfort bands; remove it")]
    WithoutEffect {
        /// The field.
        field: &'static str,
    },
    /// A field of a task that another one replaces.
    #[error("the task's `{by}` replaces its `{field}`; remove one of them")]
    Replaced {
        /// The field.
        field: &'static str,
        /// The field that replaces it.
        by: &'static str,
    },
    /// Own faults of every building, in a task without faults.
    #[error("`own-faults` has no faults to draw; add one, such as +bias0.5+own-faults, or remove it")]
    OwnFaults,
    /// A weather file with several rows an hour, and another number of steps.
    #[error("{weather} has {rows} rows an hour, so an episode needs {rows} steps per hour")]
    WeatherRows {
        /// The weather file.
        weather: std::path::PathBuf,
        /// Its rows per hour.
        rows: u32,
    },
    /// A weather file that does not cover the episode.
    #[error("{weather} does not have {missing}, a day of the episode{span}")]
    WeatherDays {
        /// The weather file.
        weather: std::path::PathBuf,
        /// The first day that it does not have.
        missing: b2b_building::Date,
        /// The days that it has.
        span: String,
    },
    /// An error of a tariff or an emission profile.
    #[error(transparent)]
    Tariff(#[from] b2b_tariff::Error),
    /// A band whose setpoints cross or are too close.
    #[error(
        "the band `{name}` heats to {heating} °C and cools to {cooling} °C; expected a cooling setpoint at least {least} K \
         above the heating setpoint"
    )]
    BandCrosses {
        /// Name of the pair.
        name: &'static str,
        /// Heating setpoint, °C.
        heating: f64,
        /// Cooling setpoint, °C.
        cooling: f64,
        /// Least difference, K.
        least: f64,
    },
    /// A value of a task outside its limits.
    #[error("task field `{name}` is {value}; expected a number from {low} to {high}")]
    TaskValue {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Lowest valid value.
        low: f64,
        /// Highest valid value.
        high: f64,
    },
    /// An error of EnergyPlus.
    #[error(transparent)]
    Engine(#[from] b2b_energyplus::Error),
    /// A building that cannot be generated or prepared, or its weather file that cannot be read.
    #[error(transparent)]
    Building(Box<dyn std::error::Error + Send + Sync>),
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: std::path::PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Returns the error of a building that cannot be generated or prepared.
    pub fn building(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Building(Box::new(error))
    }
}

impl From<b2b_building::Error> for Error {
    fn from(error: b2b_building::Error) -> Self {
        Self::building(error)
    }
}
