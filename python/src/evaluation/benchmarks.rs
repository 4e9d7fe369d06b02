//! The benchmark problems.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use b2b_benchmark::entry::{Entry, EntryPolicy, External, RunOutcome, measure_scores};
use b2b_benchmark::problem::{RestrictedAction, Stage};
use b2b_building::BuildingType;
use b2b_control::ReactiveParameters;
use b2b_dataset::BuildingId;
use b2b_energyplus::install::Quiet;
use b2b_env::EpisodeMetrics;
use b2b_evaluate::statistics::Sample;
use b2b_evaluate::{Baselines, EpisodePlan, EpisodeResult, ReturnTerms, Scores, Subject};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::buildings::catalog;
use crate::env::record::Record;
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

    /// Returns the baselines of test episodes, which are given as building id, task and run period. Unknown ones are
    /// computed, `jobs` at a time.
    fn baselines(
        &self,
        py: Python<'_>,
        episodes: Vec<(String, String, String)>,
        jobs: usize,
    ) -> PyResult<Vec<Baseline>> {
        let _running = running()?;
        let episode = |(building, task, period): (String, String, String)| {
            Ok(EpisodePlan {
                subject: Subject::at_home(building.parse().map_err(of_building)?),
                task: catalog::read_task(&task)?,
                period: period.parse().map_err(of_building)?,
                seed: 0,
                steps_per_hour: self.inner.protocol.steps_per_hour,
            })
        };
        let episodes = episodes.into_iter().map(episode).collect::<PyResult<Vec<_>>>()?;
        let known = run_policy(py, jobs, &Mutex::new(None), None, |evaluation, counter| {
            let located = episodes.into_iter().map(|episode| {
                let site = episode.subject.locate(evaluation.catalog, &mut Quiet)?;
                Ok((episode, site))
            });
            let located = located.collect::<b2b_evaluate::Result<Vec<_>>>()?;
            Baselines::open()?.of_all(evaluation, &located, counter)
        })?;
        Ok(known.into_iter().map(Baseline).collect())
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
            RunOutcome::Incomplete(rows) => Err(incomplete(&rows)),
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

/// Returns the exception of a run that lost episodes.
fn incomplete(lost: &[EpisodeResult]) -> PyErr {
    let lost = lost.iter().map(|row| match &row.outcome {
        Err(why) => format!("{}: {why}", row.info),
        Ok(_) => format!("{}: undefined score", row.info),
    });
    let lost = lost.collect::<Vec<_>>().join("\n");
    Exception::Evaluation
        .new_err(format!("{lost}\na result needs all episodes; the same call retries those that failed"))
}

/// The baseline of an episode.
#[pyclass(frozen, module = "building2building._core")]
pub struct Baseline(b2b_evaluate::Baseline);

#[pymethods]
impl Baseline {
    /// Takes an episode of the baseline as it ran. Raises if it did not run to its end.
    #[staticmethod]
    fn of(record: &Record) -> PyResult<Self> {
        let (metrics, terms) = ended(record)?;
        let (episode_return, energy) = (metrics.episode_return, metrics.energy());
        let resource = terms.used(record.spaces.episode.task.resource);
        let discomfort = terms.discomfort;
        Ok(Self(b2b_evaluate::Baseline { episode_return, energy, resource, discomfort }))
    }

    /// Its return.
    #[getter]
    fn episode_return(&self) -> f64 {
        self.0.episode_return
    }

    /// Its HVAC energy, Wh/m².
    #[getter]
    fn energy(&self) -> f64 {
        self.0.energy
    }

    /// Returns score, resolved score and HVAC energy, Wh/m², of an episode. Raises if it did not run to its end.
    fn compare(&self, record: &Record) -> PyResult<(Option<f64>, Option<f64>, f64)> {
        let (metrics, terms) = ended(record)?;
        let episode = &record.spaces.episode;
        let used = terms.used(episode.task.resource);
        let Scores { score, resolved } = self.0.scores(&metrics, used, episode.steps_per_hour);
        Ok((score, resolved, metrics.energy()))
    }
}

/// Returns the metrics of an episode and the sums of its return. Raises if it did not run to its end.
fn ended(record: &Record) -> PyResult<(EpisodeMetrics, ReturnTerms)> {
    let metrics = record
        .metrics
        .as_ref()
        .ok_or_else(|| wrong("an episode that has not run to its end has no score"))?;
    Ok((metrics.into(), metrics.into()))
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

/// Building, task, run period, seed, score and resolved score of an episode.
type EpisodeScores = (String, String, String, u64, f64, f64);

/// Returns aggregate measures as JSON text.
#[pyfunction]
pub fn measures(episodes: Vec<EpisodeScores>) -> PyResult<String> {
    fn samples((building, task, period, seed, score, resolved): &EpisodeScores) -> (Sample<'_>, Sample<'_>) {
        let building_type = building.split('-').next().unwrap_or_default();
        let sample =
            Sample { building_type, building, case: [task, period], agent: "", seed: *seed, score: *score };
        (sample, Sample { score: *resolved, ..sample })
    }
    let (scores, resolved): (Vec<_>, Vec<_>) = episodes.iter().map(samples).unzip();
    let measures = measure_scores(&scores, &resolved).ok_or_else(|| wrong("no score to aggregate"))?;
    Ok(measures.to_string())
}
