//! The benchmark problems.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use b2b_benchmark::entry::{Entry, EntryPolicy, External, RunOutcome, measure_scores};
use b2b_benchmark::problem::{RestrictedAction, Stage};
use b2b_building::BuildingType;
use b2b_control::ReactiveParameters;
use b2b_dataset::BuildingId;
use b2b_evaluate::{Baselines, Operated};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::evaluation::{InPython, run_policy, running};
use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_building};
use crate::interpreter::process::locked;
use crate::interpreter::signals::stopped;
use crate::spaces::Spaces;

fn wrong(error: impl std::fmt::Display) -> PyErr {
    Exception::Setting.new_err(error.to_string())
}

/// A benchmark problem.
#[pyclass(frozen, module = "building2building._core")]
pub struct Problem {
    /// The underlying problem.
    pub inner: b2b_benchmark::Problem,
}

#[pymethods]
impl Problem {
    /// Finds a problem by its name and applies changes (JSON text).
    #[new]
    fn new(name: &str, changes: &str) -> PyResult<Self> {
        Self::changed(b2b_benchmark::Problem::named(name).map_err(wrong)?, changes)
    }

    /// Creates a problem that trains on some building types and tests on others, and applies changes (JSON text).
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

    /// Returns the names of the problems.
    #[staticmethod]
    fn names() -> Vec<String> {
        b2b_benchmark::Problem::all().iter().map(|problem| problem.name.clone()).collect()
    }

    /// Returns the definition as JSON text.
    fn to_json(&self) -> String {
        serde_json::to_string(&self.inner).expect("it is plain data")
    }

    /// Returns the SHA-256 of its definition.
    fn hash(&self) -> String {
        self.inner.hash()
    }

    /// Returns the fields that differ from the built-in problem of the same name; `None` if there is none.
    fn changes(&self) -> Option<Vec<String>> {
        self.inner.changes()
    }

    /// Returns the building ids of a side, `train` or `test`; with `sample`, that many, evenly spaced.
    #[pyo3(signature = (side, sample = None))]
    fn building_ids(&self, side: &str, sample: Option<usize>) -> PyResult<Vec<String>> {
        let buildings = &self.side(side)?.buildings;
        let ids = sample.map_or_else(|| buildings.ids(), |count| buildings.sample(count));
        Ok(ids.iter().map(ToString::to_string).collect())
    }

    /// Errors if the building must not be used for training.
    fn check_training_building(&self, id: &str) -> PyResult<()> {
        let id: BuildingId = id.parse().map_err(of_building)?;
        self.inner.check_training_building(id).map_err(wrong)
    }

    /// Returns the restricted action space of a building on a side; `None` if it is unrestricted.
    fn restricted(&self, side: &str, spaces: &Spaces) -> PyResult<Option<Restriction>> {
        let Some(restriction) = self.side(side)?.restriction else { return Ok(None) };
        let inner = spaces.inner();
        let parameters = ReactiveParameters::tuned_for(&inner.building, &inner.episode.task);
        let restricted = restriction.apply(inner, &parameters).map_err(wrong)?;
        let widths = (inner.observation.len(), inner.action.len());
        Ok(Some(Restriction { restricted: Mutex::new(restricted), widths }))
    }

    /// Runs a policy written in Python on the problem, writes the result to a folder and returns it as JSON text.
    /// Episodes already in the folder are not run again.
    ///
    /// `make` takes spaces, building and seed and returns the controller of an episode, or of consecutive ones if its
    /// attribute `has_memory` is true and the problem says so; `train_make`, if given, does so for training buildings.
    /// `whole` is whether these controllers observe and control the whole building instead of the problem's interface.
    /// `progress` is called regularly with a label and the simulated days done and in total.
    #[pyo3(signature = (make, train_make, folder, jobs, rescale, whole, by_seed, name, identity, description, training_steps, progress=None))]
    #[allow(clippy::too_many_arguments, reason = "called by one function of the package")]
    fn run(
        &self,
        py: Python<'_>,
        make: Py<PyAny>,
        train_make: Option<Py<PyAny>>,
        folder: PathBuf,
        jobs: usize,
        rescale: bool,
        whole: bool,
        by_seed: bool,
        name: String,
        identity: String,
        description: Option<String>,
        training_steps: Option<u64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let _running = running()?;
        let raised = Arc::new(Mutex::new(None));
        let external = |make: Py<PyAny>| {
            let (name, identity, raised) = (name.clone(), identity.clone(), Arc::clone(&raised));
            let has_memory = make.getattr(py, "has_memory")?.extract(py)?;
            let own = InPython { name, identity, make, rescale, whole, has_memory, raised };
            Ok::<_, PyErr>(EntryPolicy::External(External::new(Box::new(own), by_seed)))
        };
        let entry = Entry {
            problem: self.inner.clone(),
            policy: external(make)?,
            train_policy: train_make.map(external).transpose()?,
            name: name.clone(),
            description,
            training_steps,
            adapted: BTreeMap::new(),
            upper_bound: None,
        };
        let outcome = run_policy(py, jobs, &raised, progress.as_ref(), |evaluation, counter| {
            let outcome = entry.run(&folder, evaluation, &Baselines::open()?, counter)?;
            // The last episode may have ended in an exception.
            if stopped() { Err(b2b_evaluate::Error::Interrupted) } else { Ok(outcome) }
        })?;
        match outcome {
            RunOutcome::Complete(result, _) => Ok(serde_json::to_string(&result).expect("it is plain data")),
            RunOutcome::Incomplete(rows) => {
                let lost = rows.iter().map(|row| match &row.outcome {
                    Err(why) => format!("{}: {why}", row.info),
                    Ok(_) => format!("{}: undefined score", row.info),
                });
                let lost = lost.collect::<Vec<_>>().join("\n");
                Err(Exception::Evaluation.new_err(format!(
                    "{lost}\na result needs all episodes; the same call retries those that failed"
                )))
            }
        }
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
            _ => Err(Exception::Setting.new_err(format!("unknown side `{side}`; expected train or test"))),
        }
    }
}

/// An action space with a subset of the actuators.
#[pyclass(frozen, module = "building2building._core")]
pub struct Restriction {
    restricted: Mutex<RestrictedAction>,
    widths: (usize, usize),
}

#[pymethods]
impl Restriction {
    /// Returns the indices of the remaining actuators.
    fn kept(&self) -> Vec<usize> {
        locked(&self.restricted).kept().to_vec()
    }

    /// Resets the state for a new episode.
    fn reset(&self) {
        locked(&self.restricted).reset();
    }

    /// Extends an action of the remaining actuators to all actuators, in physical units. Must be called once per step,
    /// with the observation before it.
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
                let message = format!("the {what} has {given} values; expected {expected}");
                return Err(Exception::Action.new_err(message));
            }
        }
        let mut action = vec![0.0; self.widths.1];
        restricted.complete(&observation, &chosen, &mut action);
        Ok(arrays::row(py, &action))
    }
}

/// Returns the score of a return; `None` if the ratio is undefined.
#[pyfunction]
pub fn normalized_score(episode_return: f64, baseline_return: f64) -> Option<f64> {
    b2b_evaluate::normalized_score(episode_return, baseline_return)
}

/// Returns the resolved score of a return over a number of steps; `None` if the ratio is undefined.
#[pyfunction]
pub fn resolved_score(episode_return: f64, baseline_return: f64, steps: usize) -> Option<f64> {
    b2b_evaluate::resolved_score(episode_return, baseline_return, steps)
}

/// Returns the score at comfort of an episode of some days; `own` and `baseline` are the amount of the task's resource in
/// any unit, and discomfort, K·h per zone. `None` if the ratio is undefined.
#[pyfunction]
pub fn score_at_comfort(own: (f64, f64), baseline: (f64, f64), days: f64) -> Option<f64> {
    let [own, baseline] = [own, baseline].map(|(used, discomfort)| Operated { used, discomfort });
    b2b_evaluate::score_at_comfort(own, baseline, days)
}

/// Returns aggregate measures as JSON text; `strata` holds buildings, each with the scores of its seeds, and `resolved`
/// their resolved scores.
#[pyfunction]
pub fn measures(strata: Vec<Vec<Vec<f64>>>, resolved: Vec<Vec<Vec<f64>>>) -> PyResult<String> {
    let measures = measure_scores(&strata, &resolved).ok_or_else(|| wrong("no score to aggregate"))?;
    Ok(measures.to_string())
}
