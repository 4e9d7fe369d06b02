//! The benchmark's problems, as the crates have them.

use std::sync::Mutex;

use b2b_benchmark::entry::measure_scores;
use b2b_benchmark::problem::{RestrictedAction, Stage};
use b2b_building::BuildingType;
use b2b_control::ReactiveParameters;
use b2b_dataset::BuildingId;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays;
use crate::catalog::locked;
use crate::error::{of_building, raise};
use crate::spaces::Spaces;

fn wrong(error: impl std::fmt::Display) -> PyErr {
    raise("SettingError", error.to_string())
}

/// A problem of the benchmark.
#[pyclass(frozen, module = "building2building._core")]
pub struct Problem {
    inner: b2b_benchmark::Problem,
}

#[pymethods]
impl Problem {
    /// A problem by its name, with changes (JSON).
    #[new]
    fn new(name: &str, changes: &str) -> PyResult<Self> {
        Self::changed(b2b_benchmark::Problem::named(name).map_err(wrong)?, changes)
    }

    /// From any types to any others, with changes (JSON).
    #[staticmethod]
    fn cross_domain(train: Vec<String>, test: Vec<String>, changes: &str) -> PyResult<Self> {
        let types = |names: Vec<String>| {
            names
                .iter()
                .map(|name| name.parse::<BuildingType>().map_err(of_building))
                .collect::<PyResult<Vec<_>>>()
        };
        let problem = b2b_benchmark::Problem::cross_domain(&types(train)?, &types(test)?).map_err(wrong)?;
        Self::changed(problem, changes)
    }

    /// Names of the problems.
    #[staticmethod]
    fn names() -> Vec<String> {
        b2b_benchmark::Problem::all().iter().map(|problem| problem.name.clone()).collect()
    }

    /// All of it; JSON.
    fn to_json(&self) -> String {
        serde_json::to_string(&self.inner).expect("it is plain data")
    }

    /// SHA-256 of all that matters in it.
    fn hash(&self) -> String {
        self.inner.hash()
    }

    /// In what it differs from the shipped one of its name; `None` when there is none.
    fn changes(&self) -> Option<Vec<String>> {
        self.inner.changes()
    }

    /// Ids of the buildings of a side, `train` or `test`; so many of them, spread evenly.
    #[pyo3(signature = (side, sample = None))]
    fn building_ids(&self, side: &str, sample: Option<usize>) -> PyResult<Vec<String>> {
        let buildings = &self.side(side)?.buildings;
        let ids = sample.map_or_else(|| buildings.ids(), |count| buildings.sample(count));
        Ok(ids.iter().map(ToString::to_string).collect())
    }

    /// Refuses a building that must not be trained on.
    fn check_training_building(&self, id: &str) -> PyResult<()> {
        let id: BuildingId = id.parse().map_err(of_building)?;
        self.inner.check_training_building(id).map_err(wrong)
    }

    /// What is taken away from the action of a building on a side; `None` when nothing is.
    fn restricted(&self, side: &str, spaces: &Spaces) -> PyResult<Option<Restriction>> {
        let Some(restriction) = self.side(side)?.restriction else { return Ok(None) };
        let inner = spaces.inner();
        let parameters = ReactiveParameters::tuned_for(&inner.building);
        let restricted = restriction.apply(inner, &parameters).map_err(wrong)?;
        let widths = (inner.observation.len(), inner.action.len());
        Ok(Some(Restriction { restricted: Mutex::new(restricted), widths }))
    }
}

impl Problem {
    fn changed(problem: b2b_benchmark::Problem, changes: &str) -> PyResult<Self> {
        let changes = serde_json::from_str(changes).map_err(wrong)?;
        Ok(Self { inner: problem.with(&changes).map_err(wrong)? })
    }

    fn side(&self, side: &str) -> PyResult<&b2b_benchmark::problem::Side> {
        match side {
            "train" => Ok(self.inner.side(Stage::Train)),
            "test" => Ok(self.inner.side(Stage::Test)),
            _ => Err(raise("SettingError", format!("there is no side `{side}`: give train or test"))),
        }
    }
}

/// An action space without some of its actuators.
#[pyclass(frozen, module = "building2building._core")]
pub struct Restriction {
    restricted: Mutex<RestrictedAction>,
    widths: (usize, usize),
}

#[pymethods]
impl Restriction {
    /// Numbers of the actuators that are left.
    fn kept(&self) -> Vec<usize> {
        locked(&self.restricted).kept().to_vec()
    }

    /// Forgets everything: a new episode begins.
    fn reset(&self) {
        locked(&self.restricted).reset();
    }

    /// The action of all actuators for one of the kept, in their units. Once a step, with the observation before it.
    fn complete<'py>(
        &self,
        py: Python<'py>,
        observation: &Bound<'py, PyAny>,
        chosen: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (observation, chosen) = (arrays::numbers(observation)?, arrays::numbers(chosen)?);
        let mut restricted = locked(&self.restricted);
        for (what, given, expected) in [
            ("observation", observation.len(), self.widths.0),
            ("action", chosen.len(), restricted.kept().len()),
        ] {
            if given != expected {
                let message = format!("the {what} has {given} numbers, and this building's has {expected}");
                return Err(raise("ActionError", message));
            }
        }
        let mut action = vec![0.0; self.widths.1];
        restricted.complete(&observation, &chosen, &mut action);
        Ok(arrays::row(py, &action))
    }
}

/// The score of a return; `None` where there is no ratio.
#[pyfunction]
pub fn normalized_score(episode_return: f64, baseline_return: f64) -> Option<f64> {
    b2b_benchmark::normalized_score(episode_return, baseline_return)
}

/// The measures of scores: strata of buildings, each with the scores of its seeds; JSON.
#[pyfunction]
pub fn measures(strata: Vec<Vec<Vec<f64>>>) -> PyResult<String> {
    let measures = measure_scores(&strata).ok_or_else(|| wrong("there is no score to measure"))?;
    Ok(measures.to_string())
}
