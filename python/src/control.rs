//! The built-in controllers, and the metrics of an episode.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

use b2b_agent::Agent;
use b2b_control::{AnyController, Case, KINDS, ReactiveParameters};
use b2b_env::{EpisodeMetrics, MetricValue, Metrics};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_agent, of_control};
use crate::interpreter::process::locked;
use crate::spaces::Spaces;

/// A built-in controller or a trained agent.
#[pyclass(frozen, module = "building2building._core")]
pub struct Controller {
    controller: Mutex<Box<dyn AnyController>>,
    widths: (usize, usize),
}

#[pymethods]
impl Controller {
    /// Creates a controller of a kind; `parameters` are changes to the values tuned for the building and the task.
    #[new]
    #[pyo3(signature = (kind, spaces, seed, parameters=None))]
    fn new(
        kind: &str,
        spaces: &Spaces,
        seed: u64,
        parameters: Option<BTreeMap<String, f64>>,
    ) -> PyResult<Self> {
        let inner = spaces.inner();
        let unknown = || {
            let known = KINDS.into_iter().filter(|kind| !kind.plans()).map(|kind| kind.name());
            let known = known.collect::<Vec<_>>().join(", ");
            Exception::Setting.new_err(format!("unknown controller `{kind}`; expected one of {known}"))
        };
        let kind = b2b_control::kind(kind).filter(|kind| !kind.plans()).ok_or_else(unknown)?;
        let tuned = kind.tuned(&inner.building, &inner.episode.task);
        let values = kind.changed(tuned, &parameters.unwrap_or_default()).map_err(of_control)?;
        let case = Case { spaces: inner, action: &inner.action, seed, values: &values };
        Ok(Self::of(kind.make(&case).map_err(of_control)?, inner))
    }

    /// Returns the controller of the agent in a folder.
    #[staticmethod]
    fn agent(folder: PathBuf, spaces: &Spaces) -> PyResult<Self> {
        let agent = Agent::read(&folder).map_err(of_agent)?;
        let controller = agent.controller(spaces.shared()).map_err(of_agent)?;
        Ok(Self::of(Box::new(controller), spaces.inner()))
    }

    /// Resets the state for a new episode.
    fn reset(&self) {
        locked(&self.controller).reset();
    }

    /// Begins another episode in the same building: an agent keeps its memory, if it has one.
    fn next_episode(&self) {
        locked(&self.controller).next_episode();
    }

    /// Takes the reward of the last action, which an agent with memory may observe.
    fn reward(&self, reward: f64) {
        locked(&self.controller).reward(reward);
    }

    /// Returns a copy with the current state.
    fn copy(&self) -> Self {
        Self { controller: Mutex::new(locked(&self.controller).boxed_clone()), widths: self.widths }
    }

    /// Returns the action for an observation, both in physical units.
    fn act<'py>(
        &self,
        py: Python<'py>,
        observation: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let observation = arrays::numbers(observation)?;
        if observation.len() != self.widths.0 {
            let (given, expected) = (observation.len(), self.widths.0);
            let message = format!("the observation has {given} values; the controller expects {expected}");
            return Err(Exception::Action.new_err(message));
        }
        let mut action = vec![0.0; self.widths.1];
        locked(&self.controller).act(&observation, &mut action);
        Ok(arrays::row(py, &action))
    }
}

impl Controller {
    fn of(controller: Box<dyn AnyController>, spaces: &b2b_env::Spaces) -> Self {
        Self { controller: Mutex::new(controller), widths: (spaces.observation.len(), spaces.action.len()) }
    }
}

/// Returns the parameters of the reactive controllers that are tuned for a building and a task, by name.
#[pyfunction]
pub fn reactive_parameters(spaces: &Spaces) -> BTreeMap<&'static str, f64> {
    let inner = spaces.inner();
    let tuned = ReactiveParameters::tuned_for(&inner.building, &inner.episode.task);
    ReactiveParameters::TABLE.iter().map(|field| (field.parameter.name, field.of(&tuned))).collect()
}

/// Returns the metrics of an episode as a dictionary, with the names of `b2b run --json`.
pub fn metrics<'py>(py: Python<'py>, metrics: &Metrics) -> PyResult<Bound<'py, PyAny>> {
    let all = PyDict::new(py);
    for (name, value) in EpisodeMetrics::from(metrics).values() {
        match value {
            Some(MetricValue::Count(count)) => all.set_item(name, count)?,
            Some(MetricValue::Number(number)) => all.set_item(name, number)?,
            None => all.set_item(name, py.None())?,
        }
    }
    Ok(all.into_any())
}
