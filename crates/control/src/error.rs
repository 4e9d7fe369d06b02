//! Errors of controllers and their tuning.

use std::path::PathBuf;

use b2b_building::parameter::OutOfBounds;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The controller `own` for a building that is not under its own controls.
    #[error(
        "{building} has {actuators} actuators; the controller `own` needs the building prepared under its own controls, without actuators"
    )]
    OwnControls {
        /// Name of the building.
        building: String,
        /// Number of its actuators.
        actuators: usize,
    },
    /// A task with faults for the controller `own`, whose sensors and actuators are the engine's.
    #[error(
        "task `{task}` has faults, which have no effect under the controller `own`: its sensors and actuators are \
         EnergyPlus's; leave the faults out, or compare with `guideline36`"
    )]
    FaultsWithoutEffect {
        /// The task.
        task: String,
    },
    /// A parameter of a controller outside its bounds.
    #[error(transparent)]
    Parameter(#[from] OutOfBounds),
    /// An unknown parameter of a controller.
    #[error("unknown parameter `{name}` of {controller}; expected one of {}", known.join(", "))]
    UnknownParameter {
        /// The controller.
        controller: &'static str,
        /// The name.
        name: String,
        /// The names of all parameters.
        known: Vec<&'static str>,
    },
    /// A file that does not hold parameters.
    #[error("{path} is not a valid file of controller parameters: {why}")]
    ParameterFile {
        /// The file.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// A name that no controller has.
    #[error("unknown controller `{name}`; expected one of {}", known.join(", "))]
    UnknownKind {
        /// The name.
        name: String,
        /// The known names.
        known: Vec<&'static str>,
    },
    /// Parameters given to a controller that has none.
    #[error("the controller `{name}` has no parameters")]
    NoParameters {
        /// The controller.
        name: &'static str,
    },
    /// Values that do not fit a controller's parameters.
    #[error("invalid parameters of a controller: {why}")]
    Values {
        /// Reason.
        why: String,
    },
    /// A planner without an episode on which to try actions or to identify a model.
    #[error(
        "the controller `{name}` runs episodes of its building before it acts; it can run in `b2b run` and in evaluations"
    )]
    NeedsEpisode {
        /// The controller.
        name: &'static str,
    },
    /// A task without comfort bands or without a weight of energy.
    #[error(
        "the controller `{name}` minimizes cost at equal comfort, but the task `{task}` has no comfort bands or no energy weight; use operate"
    )]
    NotOperation {
        /// The controller.
        name: &'static str,
        /// The task.
        task: String,
    },
    /// A file of another tuning run or search, or one that was edited.
    #[error("{path} belongs to another tuning run: {why}; remove it or choose another folder")]
    OtherTuning {
        /// The file.
        path: PathBuf,
        /// The difference.
        why: String,
    },
    /// A request for more training buildings than available.
    #[error("cannot draw {requested} training buildings: {class} has {available}; expected 1 to {available}")]
    TooFewBuildings {
        /// The class.
        class: String,
        /// Available buildings.
        available: usize,
        /// Requested buildings.
        requested: usize,
    },
    /// An unknown objective.
    #[error("unknown objective `{text}`; expected comfort or energy")]
    UnknownObjective {
        /// The text.
        text: String,
    },
    /// A lost episode.
    #[error("an episode of {building} was lost: {why}")]
    Lost {
        /// Name of the building.
        building: String,
        /// Reason.
        why: String,
    },
    /// A failure of the optimizer.
    #[error("the search for parameters failed: {0}")]
    Search(String),
    /// A building that cannot be generated or prepared.
    #[error(transparent)]
    Building(Box<b2b_dataset::Error>),
    /// An error of an environment.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
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
