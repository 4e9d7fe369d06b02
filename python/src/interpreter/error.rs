//! The package's exceptions, and the conversion of the crates' errors to them.

use pyo3::exceptions::{PyException, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};
use pyo3::{PyErr, PyTypeInfo};

use crate::interpreter::signals::interrupt;

/// An exception of the package. The classes are created here; `building2building.errors` re-exports them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exception {
    Base,
    Install,
    Building,
    Task,
    Setting,
    Action,
    Episode,
    Engine,
    Evaluation,
    Process,
}

/// The classes of the exceptions, in the order of [`Exception`].
static CLASSES: PyOnceLock<Vec<Py<PyType>>> = PyOnceLock::new();

impl Exception {
    const ALL: [Self; 10] = [
        Self::Base,
        Self::Install,
        Self::Building,
        Self::Task,
        Self::Setting,
        Self::Action,
        Self::Episode,
        Self::Engine,
        Self::Evaluation,
        Self::Process,
    ];

    /// Returns the name of the class.
    pub fn name(self) -> &'static str {
        match self {
            Self::Base => "Error",
            Self::Install => "InstallError",
            Self::Building => "BuildingError",
            Self::Task => "TaskError",
            Self::Setting => "SettingError",
            Self::Action => "ActionError",
            Self::Episode => "EpisodeError",
            Self::Engine => "EngineError",
            Self::Evaluation => "EvaluationError",
            Self::Process => "ProcessError",
        }
    }

    fn doc(self) -> &'static str {
        match self {
            Self::Base => "Base class of all errors of this package.",
            Self::Install => "EnergyPlus or a weather file is missing and could not be downloaded.",
            Self::Building => "An unknown building, or a model that cannot be used as an environment.",
            Self::Task => "An invalid task.",
            Self::Setting => "An invalid argument, such as a time step, a window or a mode.",
            Self::Action => "An action of the wrong shape, or with a value that is not finite.",
            Self::Episode => "No episode is in progress, or its process has died.",
            Self::Engine => "EnergyPlus failed.",
            Self::Evaluation => {
                "An unknown policy, or an evaluation folder that is damaged or holds another evaluation."
            }
            Self::Process => {
                "The system refused a resource that worker processes need, or an environment was used from a process \
                 or thread that does not own it."
            }
        }
    }

    /// Returns the built-in class that the class derives from in addition to `Error`.
    fn builtin(self, py: Python<'_>) -> Option<Bound<'_, PyType>> {
        match self {
            Self::Base | Self::Install => None,
            Self::Building | Self::Task | Self::Setting | Self::Action => Some(PyValueError::type_object(py)),
            Self::Episode | Self::Engine | Self::Evaluation | Self::Process => {
                Some(PyRuntimeError::type_object(py))
            }
        }
    }

    /// Returns the class.
    ///
    /// # Errors
    /// The exceptions that Python raises while the classes are created on first use.
    pub fn class(self, py: Python<'_>) -> PyResult<Bound<'_, PyType>> {
        let classes = CLASSES.get_or_try_init(py, || make_classes(py))?;
        Ok(classes[self as usize].bind(py).clone())
    }

    /// Returns an instance to raise.
    pub fn new_err(self, message: impl Into<String>) -> PyErr {
        let message = message.into();
        Python::attach(|py| match self.class(py) {
            Ok(class) => PyErr::from_type(class, message),
            Err(error) => error,
        })
    }
}

fn make_classes(py: Python<'_>) -> PyResult<Vec<Py<PyType>>> {
    let mut classes: Vec<Py<PyType>> = Vec::with_capacity(Exception::ALL.len());
    for exception in Exception::ALL {
        let base = classes.first().map_or_else(|| PyException::type_object(py), |base| base.bind(py).clone());
        let bases: Vec<_> = std::iter::once(base).chain(exception.builtin(py)).collect();
        let bases = PyTuple::new(py, bases)?;
        let attributes = PyDict::new(py);
        attributes.set_item("__module__", "building2building.errors")?;
        attributes.set_item("__doc__", exception.doc())?;
        let class = py.get_type::<PyType>().call1((exception.name(), bases, attributes))?;
        classes.push(class.cast_into::<PyType>()?.unbind());
    }
    Ok(classes)
}

/// Adds the classes to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    Exception::ALL.into_iter().try_for_each(|each| module.add(each.name(), each.class(module.py())?))
}

/// Converts an error of a building to an exception.
pub fn of_building(error: impl Into<b2b_dataset::Error>) -> PyErr {
    use b2b_dataset::Error;
    let error = error.into();
    let exception = match &error {
        Error::Install(source) | Error::Climate(b2b_climate::Error::Install(source)) => match source {
            b2b_energyplus::install::Error::Cancelled { .. } => return interrupt(),
            _ => Exception::Install,
        },
        Error::Engine(source) => match source {
            b2b_energyplus::Error::Interrupted => return interrupt(),
            _ => Exception::Engine,
        },
        Error::Building(source) => match &**source {
            b2b_building::Error::Engine(b2b_energyplus::Error::Interrupted) => return interrupt(),
            b2b_building::Error::Engine(_) => Exception::Engine,
            _ => Exception::Building,
        },
        _ => Exception::Building,
    };
    exception.new_err(error.to_string())
}

/// Converts an error of an environment to an exception.
pub fn of_env(error: b2b_env::Error) -> PyErr {
    use b2b_env::Error;
    let exception = match &error {
        Error::Interrupted => return interrupt(),
        Error::ActionNotFinite { .. } | Error::ActionLength { .. } => Exception::Action,
        Error::NotReset | Error::Busy | Error::Lost { .. } | Error::OtherSnapshot { .. } => {
            Exception::Episode
        }
        Error::Template { .. }
        | Error::TooWide { .. }
        | Error::SlotWithoutNode { .. }
        | Error::Building(_) => Exception::Building,
        Error::UnknownTask { .. }
        | Error::InvalidTask { .. }
        | Error::TaskFile { .. }
        | Error::TaskValue { .. }
        | Error::NeedsBands { .. }
        | Error::WithoutEffect { .. }
        | Error::Replaced { .. }
        | Error::OwnFaults
        | Error::BandCrosses { .. }
        | Error::Tariff(_) => Exception::Task,
        Error::StepsPerHour(_)
        | Error::Window { .. }
        | Error::WeatherRows { .. }
        | Error::WeatherDays { .. }
        | Error::Weight(_)
        | Error::NoBuilding
        | Error::NoEnvironment => Exception::Setting,
        Error::Engine(_) | Error::EpisodeLength { .. } | Error::ObservationNotFinite { .. } => {
            Exception::Engine
        }
        Error::Pool { .. } | Error::Io { .. } => Exception::Process,
    };
    exception.new_err(error.to_string())
}

/// Converts an error of a task to an exception: also files that it names are part of it.
pub fn of_task(error: b2b_env::Error) -> PyErr {
    match error {
        b2b_env::Error::Io { .. } => Exception::Task.new_err(error.to_string()),
        error => of_env(error),
    }
}

/// Converts an error of a controller to an exception.
pub fn of_control(error: b2b_control::Error) -> PyErr {
    Exception::Setting.new_err(error.to_string())
}

/// Converts an error of an agent to an exception.
pub fn of_agent(error: b2b_agent::Error) -> PyErr {
    let exception = match &error {
        b2b_agent::Error::UnknownObservation { .. }
        | b2b_agent::Error::NotOperation { .. }
        | b2b_agent::Error::NothingToSet { .. } => Exception::Setting,
        _ => Exception::Evaluation,
    };
    exception.new_err(error.to_string())
}

/// Converts an error of a training run to an exception.
pub fn of_training(error: b2b_learn::Error) -> PyErr {
    use b2b_learn::Error;
    match error {
        Error::Building(error) => of_building(*error),
        Error::Env(error) => of_env(error),
        Error::Agent(error) => of_agent(error),
        Error::Evaluation(error) => of_evaluation(*error),
        Error::Interrupted => interrupt(),
        error @ (Error::Config { .. }
        | Error::Invalid(_)
        | Error::ConfigFile { .. }
        | Error::Resume { .. }) => Exception::Setting.new_err(error.to_string()),
        error => Exception::Evaluation.new_err(error.to_string()),
    }
}

/// Converts an error of an evaluation to an exception.
pub fn of_evaluation(error: impl Into<b2b_evaluate::Error>) -> PyErr {
    use b2b_evaluate::Error;
    match error.into() {
        Error::Building(error) => of_building(*error),
        Error::Env(error) => of_env(error),
        Error::Interrupted => interrupt(),
        Error::Agent(error) => of_agent(error),
        error => {
            let exception = match &error {
                Error::Install(_) => Exception::Install,
                Error::ObservationShape { .. } | Error::ActionShape { .. } => Exception::Action,
                Error::NoEpisode => Exception::Setting,
                _ => Exception::Evaluation,
            };
            exception.new_err(error.to_string())
        }
    }
}
