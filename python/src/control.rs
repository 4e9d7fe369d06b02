//! The built-in controllers, and the metrics of an episode.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

use b2b_agent::{Agent, AgentController};
use b2b_control::{Constant, Random, Reactive, ReactiveParameters};
use b2b_env::{EpisodeMetrics, MetricValue, Metrics, Trajectory};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::catalog::locked;
use crate::error::{Exception, of_agent, of_control};
use crate::spaces::Spaces;

/// A built-in controller: reactive, random, constant, or a trained agent.
#[pyclass(frozen, module = "building2building._core")]
pub struct Controller {
    controller: Mutex<Kind>,
    widths: (usize, usize),
}

#[derive(Clone)]
enum Kind {
    Reactive(Reactive),
    Random(Box<Random>),
    Constant(Constant),
    Agent(Box<AgentController>),
}

impl Kind {
    fn controller(&mut self) -> &mut dyn b2b_control::Controller {
        match self {
            Self::Reactive(controller) => controller,
            Self::Random(controller) => controller.as_mut(),
            Self::Constant(controller) => controller,
            Self::Agent(controller) => controller.as_mut(),
        }
    }
}

#[pymethods]
impl Controller {
    /// Creates a controller; `parameters` are changes to the tuned parameters of the reactive controllers.
    #[new]
    #[pyo3(signature = (kind, spaces, seed, parameters=None))]
    fn new(
        kind: &str,
        spaces: &Spaces,
        seed: u64,
        parameters: Option<BTreeMap<String, f64>>,
    ) -> PyResult<Self> {
        let inner = spaces.inner();
        let controller = match kind {
            "reactive" => Kind::Reactive(Reactive::new(
                &inner.building,
                &inner.observation,
                inner.episode.steps_per_hour,
                &changed(tuned(spaces), parameters.unwrap_or_default()).map_err(of_control)?,
            )),
            "random" => Kind::Random(Box::new(Random::new(&inner.action, seed))),
            "constant" => Kind::Constant(Constant::middle(&inner.action)),
            _ => {
                let message = format!("unknown controller `{kind}`; expected reactive, random or constant");
                return Err(Exception::Setting.new_err(message));
            }
        };
        Ok(Self { controller: Mutex::new(controller), widths: (inner.observation.len(), inner.action.len()) })
    }

    /// Returns the controller of the agent in a folder.
    #[staticmethod]
    fn agent(folder: PathBuf, spaces: &Spaces) -> PyResult<Self> {
        let agent = Agent::read(&folder).map_err(of_agent)?;
        let controller = Kind::Agent(Box::new(agent.controller(spaces.shared()).map_err(of_agent)?));
        let inner = spaces.inner();
        let widths = (inner.observation.len(), inner.action.len());
        Ok(Self { controller: Mutex::new(controller), widths })
    }

    /// Resets the state for a new episode.
    fn reset(&self) {
        locked(&self.controller).controller().reset();
    }

    /// Returns a copy with the current state.
    fn copy(&self) -> Self {
        Self { controller: Mutex::new(locked(&self.controller).clone()), widths: self.widths }
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
        locked(&self.controller).controller().act(&observation, &mut action);
        Ok(arrays::row(py, &action))
    }
}

/// Returns the parameters of the reactive controllers that are tuned for a building and a task, by name.
#[pyfunction]
pub fn reactive_parameters(spaces: &Spaces) -> BTreeMap<&'static str, f64> {
    let tuned = tuned(spaces);
    ReactiveParameters::TABLE.iter().map(|field| (field.parameter.name, field.of(&tuned))).collect()
}

fn tuned(spaces: &Spaces) -> ReactiveParameters {
    let inner = spaces.inner();
    ReactiveParameters::tuned_for(&inner.building, &inner.episode.task)
}

/// Returns the parameters with changes.
fn changed(
    mut parameters: ReactiveParameters,
    changes: BTreeMap<String, f64>,
) -> b2b_control::Result<ReactiveParameters> {
    changes.iter().try_for_each(|(name, value)| parameters.set(name, *value))?;
    parameters.check()?;
    Ok(parameters)
}

/// Returns the trajectory hash that `b2b run` prints; observations, actions and penalties have one row per step.
#[pyfunction]
pub fn trajectory_hash(
    observations: &Bound<'_, PyAny>,
    actions: &Bound<'_, PyAny>,
    penalties: &Bound<'_, PyAny>,
) -> PyResult<String> {
    let (penalties, _) = arrays::rows(penalties)?;
    let trajectory = Trajectory {
        observations: arrays::rows(observations)?.0,
        actions: arrays::rows(actions)?.0,
        penalties: penalties.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect(),
    };
    Ok(trajectory.hash())
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
