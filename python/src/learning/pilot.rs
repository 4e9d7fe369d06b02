//! The interface of agents for learning libraries: their observation, and the meaning of their actions.

use std::sync::Mutex;

use b2b_agent::{Interface, ObservationForm, Pilot as Own};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_agent};
use crate::interpreter::process::locked;
use crate::spaces::Spaces;

/// The observations and actions of an agent in an episode of a building.
#[pyclass(frozen, module = "building2building._core")]
pub struct Pilot {
    own: Mutex<Own>,
    slots: usize,
    hold: usize,
}

#[pymethods]
impl Pilot {
    /// Creates the pilot of an agent with an observation form and an action mode, such as `supervisory:60`.
    #[new]
    fn new(spaces: &Spaces, observation: &str, acting: &str) -> PyResult<Self> {
        let form: ObservationForm = observation.parse().map_err(of_agent)?;
        let acting: b2b_agent::Acting =
            acting.parse().map_err(|why: String| Exception::Setting.new_err(why))?;
        let inner = spaces.shared();
        acting.check(inner.episode.steps_per_hour).map_err(|why| Exception::Setting.new_err(why))?;
        let interface = Interface { observation: form.into(), acting, nodes: None };
        let own = Own::new(interface, inner).map_err(of_agent)?;
        let hold = acting.hold(inner.episode.steps_per_hour);
        Ok(Self { own: Mutex::new(own), slots: inner.observation.len(), hold })
    }

    /// Number of steps for which a decision is held.
    #[getter]
    fn hold(&self) -> usize {
        self.hold
    }

    /// Returns the names of the slots of its observation.
    fn observation_names(&self) -> Vec<String> {
        locked(&self.own).observation().names()
    }

    /// Returns the names of its actions, each in [-1, 1].
    fn action_names(&self) -> Vec<String> {
        locked(&self.own).action_names().to_vec()
    }

    /// Begins an episode.
    fn reset(&self) {
        locked(&self.own).reset();
    }

    /// Takes the next observation of the environment and returns the agent's.
    fn observe<'py>(
        &self,
        py: Python<'py>,
        observation: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let observation = arrays::numbers(observation)?;
        let seen = observation.get(..self.slots).ok_or_else(|| {
            let (given, expected) = (observation.len(), self.slots);
            Exception::Action
                .new_err(format!("the observation has {given} values; expected at least {expected}"))
        })?;
        Ok(PyArray1::from_slice(py, locked(&self.own).observe(seen)))
    }

    /// Returns the action of a step in physical units, for an action of the agent.
    fn act<'py>(&self, py: Python<'py>, action: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let action: Vec<f32> = arrays::numbers(action)?.into_iter().map(|value| value as f32).collect();
        let mut own = locked(&self.own);
        let expected = own.widths().1;
        if action.len() != expected || action.iter().any(|value| !value.is_finite()) {
            let message = format!("the action is {action:?}; expected {expected} finite values");
            return Err(Exception::Action.new_err(message));
        }
        Ok(arrays::row(py, own.act(&action)))
    }
}
