//! An environment in this process, for debuggers and profilers; only one at a time.

use std::path::PathBuf;
use std::sync::Arc;

use b2b_env::{Spaces as EnvSpaces, to_info_numbers};
use b2b_workers::{EpisodeReport, Source};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::buildings::catalog::{self, Setting};
use crate::control;
use crate::env::record::Record;
use crate::env::{Observations, Stepped};
use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_building, of_env};
use crate::interpreter::process::OwnerProcess;
use crate::spaces::Spaces;

/// An environment in this process. The engine's stack belongs to this thread, so it cannot move to another thread.
#[pyclass(unsendable, module = "building2building._core")]
pub struct LocalEnv {
    env: Option<b2b_env::Env>,
    setting: Setting,
    spaces: Arc<EnvSpaces>,
    applied_action: Vec<f64>,
    owner: OwnerProcess,
}

#[pymethods]
impl LocalEnv {
    #[new]
    #[pyo3(signature = (setting, engine_output=None))]
    fn new(py: Python<'_>, setting: &Setting, engine_output: Option<PathBuf>) -> PyResult<Self> {
        let library = py.detach(catalog::catalog)?.library().clone();
        let episode = setting.setting.episode.clone();
        let source = Source::clone(&setting.setting.source);
        let building = source.prepare(&library).map_err(of_building)?;
        let building = Arc::new(building);
        let spaces = EnvSpaces::new(Arc::clone(&building), episode.clone());
        let mut env = b2b_env::Env::new(library, building, episode).map_err(of_env)?;
        if let Some(folder) = engine_output {
            env = env.keep_engine_output(&folder).map_err(of_env)?;
        }
        Ok(Self {
            applied_action: vec![0.0; env.action_space().len()],
            env: Some(env),
            setting: setting.clone(),
            spaces: Arc::new(spaces),
            owner: OwnerProcess::this(),
        })
    }

    /// Returns the spaces.
    fn spaces(&self) -> Spaces {
        Spaces::new(Arc::clone(&self.spaces), Arc::clone(&self.setting.building))
    }

    /// Starts an episode and returns the first observation.
    fn reset<'py>(&mut self, py: Python<'py>) -> PyResult<Observations<'py>> {
        let observation = self.env()?.reset().map_err(of_env)?.to_vec();
        Ok((arrays::single(py, &observation), arrays::row(py, &observation)))
    }

    /// Runs a step, like `Env.step`.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        action: &Bound<'py, PyAny>,
        rescale: bool,
    ) -> PyResult<Stepped<'py>> {
        let mut action = arrays::numbers(action)?;
        if rescale {
            self.spaces.action.rescale(&mut action);
        }
        let env = self.env.as_mut().ok_or_else(closed)?;
        let step = env.step(&action).map_err(of_env)?;
        self.applied_action.copy_from_slice(step.action);
        let numbers = to_info_numbers(step.reward, &step.terms);
        let observation = step.observation.to_vec();
        let single = arrays::single(py, &observation);
        Ok((single, arrays::row(py, &observation), numbers, step.truncated))
    }

    /// Repeats an action for `steps` steps without returning to Python, to measure the cost of a step in Rust alone.
    fn hold(&mut self, py: Python<'_>, action: &Bound<'_, PyAny>, steps: usize) -> PyResult<()> {
        let action = arrays::numbers(action)?;
        let env = self.env()?;
        for _ in 0..steps {
            env.step(&action).map_err(of_env)?;
        }
        py.check_signals()
    }

    /// Returns the last action as applied: clamped, in physical units.
    fn applied_action<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::row(py, &self.applied_action)
    }

    /// Returns the metrics of the episode so far.
    fn metrics<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        control::metrics(py, self.env()?.metrics())
    }

    /// Returns the spaces and metrics of the episode, for writing its files.
    fn record(&mut self) -> PyResult<Record> {
        let (spaces, place) = (Arc::clone(&self.spaces), self.setting.building.place().to_owned());
        let env = self.env()?;
        let metrics = env.is_truncated().then(|| env.metrics().clone());
        let report = EpisodeReport { engine: env.engine_report(), ..EpisodeReport::default() };
        Ok(Record { spaces, place, metrics, report: Some(report) })
    }

    /// Ends the episode and the engine.
    fn close(&mut self) {
        let env = self.env.take();
        if !self.owner.is_current() {
            // In a fork, the engine's files are the parent's.
            std::mem::forget(env);
        }
    }
}

impl Drop for LocalEnv {
    fn drop(&mut self) {
        self.close();
    }
}

impl LocalEnv {
    fn env(&mut self) -> PyResult<&mut b2b_env::Env> {
        self.env.as_mut().ok_or_else(closed)
    }
}

fn closed() -> PyErr {
    Exception::Episode.new_err("the environment is closed")
}
