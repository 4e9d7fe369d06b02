//! Errors of the crates as the package's exceptions, with the crates' own words.

use pyo3::PyErr;
use pyo3::prelude::*;

/// An exception of `building2building.errors` by its name.
pub fn raise(name: &str, message: String) -> PyErr {
    Python::attach(|py| {
        let exception = py.import("building2building.errors").and_then(|module| module.getattr(name));
        match exception.and_then(|exception| exception.call1((message,))) {
            Ok(instance) => PyErr::from_value(instance),
            Err(error) => error,
        }
    })
}

/// What went wrong with a building.
pub fn of_building(error: impl Into<b2b_dataset::Error>) -> PyErr {
    use b2b_dataset::Error;
    let error = error.into();
    let name = match &error {
        Error::Install(source) | Error::Climate(b2b_climate::Error::Install(source)) => match source {
            b2b_energyplus::install::Error::Cancelled { .. } => return crate::pools::interrupt(),
            _ => "InstallError",
        },
        Error::Engine(_) => "EngineError",
        Error::Building(source) if matches!(**source, b2b_building::Error::Engine(_)) => "EngineError",
        _ => "BuildingError",
    };
    raise(name, error.to_string())
}

/// What went wrong in an environment.
pub fn of_env(error: b2b_env::Error) -> PyErr {
    use b2b_env::Error;
    let name = match &error {
        Error::Interrupted => return crate::pools::interrupt(),
        Error::ActionNotFinite { .. } | Error::ActionLength { .. } => "ActionError",
        Error::NotReset | Error::Gone { .. } => "EpisodeError",
        Error::Template { .. } | Error::TooWide { .. } => "BuildingError",
        Error::UnknownTask { .. } | Error::TaskFile { .. } | Error::TaskValue { .. } => "TaskError",
        Error::StepsPerHour(_) | Error::Window { .. } | Error::NoEnvironment => "SettingError",
        Error::Engine(_) | Error::EpisodeLength { .. } | Error::ObservationNotFinite { .. } => "EngineError",
        _ => "ProcessError",
    };
    raise(name, error.to_string())
}

/// What went wrong in an evaluation.
pub fn of_benchmark(error: b2b_benchmark::Error) -> PyErr {
    use b2b_benchmark::Error;
    match error {
        Error::Building(error) => of_building(*error),
        Error::Env(error) => of_env(error),
        Error::Interrupted => crate::pools::interrupt(),
        error => {
            let name = match &error {
                Error::Install(_) => "InstallError",
                Error::ObservationShape { .. } | Error::ActionShape { .. } => "ActionError",
                Error::NoEpisode => "SettingError",
                _ => "EvaluationError",
            };
            raise(name, error.to_string())
        }
    }
}
