//! A batch of environments.

use std::sync::{Arc, Mutex};

use b2b_env::vector::{AnyOf, Autoreset, Fixed, Sampler, VecEnv as Envs, VecEnvOptions, Windows};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::catalog::{Inner, Setting, locked};
use crate::error::{Exception, of_env};
use crate::pools::{self, Owner};
use crate::spaces::Spaces;
use crate::{arrays, control};

/// A batch of environments, each in its own process.
#[pyclass(frozen, module = "building2building._core")]
pub struct VecEnv {
    owner: Owner,
    state: Mutex<State>,
    spaces: Vec<(Arc<b2b_env::Spaces>, Arc<Inner>)>,
}

struct State {
    /// `None` once closed.
    envs: Option<Envs>,
    rescale: bool,
}

/// Observations, rewards, penalties and truncations of the batch.
type Stepped<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<bool>>,
);

/// The data of [`Stepped`].
struct Batch {
    observations: Vec<f32>,
    rewards: Vec<f64>,
    penalties: Vec<f64>,
    truncated: Vec<bool>,
    shape: [usize; 2],
}

/// The end of an episode: last observation, metrics, and the reason if it was lost.
type Ended<'py> = (Bound<'py, PyArray1<f64>>, Option<Bound<'py, PyAny>>, Option<String>);

#[pymethods]
impl VecEnv {
    /// Prepares the buildings. With `any`, every episode is drawn from all settings; otherwise environment i repeats
    /// setting i. `window` is the length of an episode in days and the number of first days to draw from.
    #[new]
    #[pyo3(signature = (settings, count, autoreset, rescale, any, window=None))]
    fn new(
        py: Python<'_>,
        settings: Vec<PyRef<'_, Setting>>,
        count: usize,
        autoreset: &str,
        rescale: bool,
        any: bool,
        window: Option<(u32, u32)>,
    ) -> PyResult<Self> {
        let autoreset = match autoreset {
            "NextStep" => Autoreset::NextStep,
            "SameStep" => Autoreset::SameStep,
            "Disabled" => Autoreset::Disabled,
            _ => return Err(Exception::Setting.new_err(format!("unknown autoreset mode `{autoreset}`"))),
        };
        let mut workers = pools::options(py)?;
        workers.template_memory = 2 << 30;
        let settings: Vec<Setting> = settings.iter().map(|setting| (*setting).clone()).collect();
        let all: Vec<_> = settings.iter().map(|setting| setting.setting.clone()).collect();
        let (state, spaces) = py.detach(|| -> PyResult<_> {
            let options = VecEnvOptions { workers, autoreset, widths: None };
            let mut envs = Envs::new(count, sampler(all.clone(), any, window), options).map_err(of_env)?;
            let spaces = envs.prepare(&all).map_err(of_env)?;
            Ok((State { envs: Some(envs), rescale }, spaces))
        })?;
        let buildings = settings.into_iter().map(|setting| setting.building);
        Ok(Self {
            owner: Owner::this(),
            state: Mutex::new(state),
            spaces: spaces.into_iter().zip(buildings).collect(),
        })
    }

    /// Returns the spaces of each setting.
    fn spaces(&self) -> Vec<Spaces> {
        let spaces = self.spaces.iter();
        spaces.map(|(spaces, building)| Spaces::new(Arc::clone(spaces), Arc::clone(building))).collect()
    }

    /// Begins an episode in every environment.
    fn reset<'py>(&self, py: Python<'py>, seed: u64) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let batch = self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            envs.reset(seed).map_err(of_env)?;
            Ok(Batch::of(envs))
        })?;
        arrays::table(py, batch.observations, batch.shape)
    }

    /// Begins an episode in the given environments.
    fn reset_some<'py>(&self, py: Python<'py>, which: Vec<usize>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let batch = self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            for index in &which {
                envs.reset_one(*index).map_err(of_env)?;
            }
            envs.recv(which.len(), &mut Vec::new()).map_err(of_env)?;
            let lost = which.iter().find_map(|index| envs.lost(*index));
            match lost {
                Some(why) => Err(Exception::Episode.new_err(format!("an episode was lost: {why}"))),
                None => Ok(Batch::of(envs)),
            }
        })?;
        arrays::table(py, batch.observations, batch.shape)
    }

    /// Runs one step of every environment.
    fn step<'py>(&self, py: Python<'py>, actions: &Bound<'py, PyAny>) -> PyResult<Stepped<'py>> {
        let (mut actions, shape) = arrays::rows(actions)?;
        let batch = self.owner.with(py, &self.state, |state| {
            let rescale = state.rescale;
            let envs = state.envs()?;
            let expected = [envs.len(), envs.widths().0];
            if shape != expected {
                let message = format!("the actions have shape {shape:?}; expected {expected:?}");
                return Err(Exception::Action.new_err(message));
            }
            if rescale {
                for (index, action) in actions.chunks_exact_mut(expected[1]).enumerate() {
                    if let Some(spaces) = envs.spaces(index) {
                        spaces.action.rescale(action);
                    }
                }
            }
            envs.step(&actions).map_err(of_env)?;
            Ok(Batch::of(envs))
        })?;
        Ok((
            arrays::table(py, batch.observations, batch.shape)?,
            arrays::row(py, &batch.rewards),
            arrays::table(py, batch.penalties, [batch.shape[0], 2])?,
            arrays::row(py, &batch.truncated),
        ))
    }

    /// Repeats actions in physical units for `steps` steps without returning to Python: the cost of a step in Rust alone.
    fn hold(&self, py: Python<'_>, actions: &Bound<'_, PyAny>, steps: usize) -> PyResult<()> {
        let (actions, _) = arrays::rows(actions)?;
        self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            (0..steps).try_for_each(|_| envs.step(&actions).map(|_| ()).map_err(of_env))
        })
    }

    /// Returns the end of the last episode of an environment.
    fn ended<'py>(&self, py: Python<'py>, environment: usize) -> PyResult<Ended<'py>> {
        let (observation, metrics, lost) = self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            let observation = envs.final_observation(environment).to_vec();
            let lost = envs.lost(environment).map(str::to_owned);
            Ok((observation, envs.final_metrics(environment).cloned(), lost))
        })?;
        let metrics = metrics.map(|metrics| control::metrics(py, &metrics)).transpose()?;
        Ok((arrays::row(py, &observation), metrics, lost))
    }

    /// Returns the name of the building that each environment runs.
    fn buildings(&self, py: Python<'_>) -> PyResult<Vec<Option<String>>> {
        self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            let name = |index| envs.spaces(index).map(|spaces| spaces.building.name.clone());
            Ok((0..envs.len()).map(name).collect())
        })
    }

    /// Width of a row of actions and of a row of observations; 0 before the first reset.
    #[getter]
    fn widths(&self, py: Python<'_>) -> PyResult<(usize, usize)> {
        self.owner.with(py, &self.state, |state| Ok(state.envs()?.widths()))
    }

    /// Ends all processes.
    fn close(&self, py: Python<'_>) {
        if self.owner.is_here() {
            py.detach(|| locked(&self.state).envs = None);
        }
    }
}

impl State {
    fn envs(&mut self) -> PyResult<&mut Envs> {
        let closed = || Exception::Episode.new_err("the environments are closed");
        self.envs.as_mut().ok_or_else(closed)
    }
}

impl Batch {
    fn of(envs: &Envs) -> Self {
        let penalties = |reward: &b2b_env::Reward| [reward.temperature_penalty, reward.energy_penalty];
        Self {
            observations: envs.observations().iter().map(|value| *value as f32).collect(),
            rewards: envs.rewards().iter().map(|reward| reward.total()).collect(),
            penalties: envs.rewards().iter().flat_map(penalties).collect(),
            truncated: envs.truncated().to_vec(),
            shape: [envs.len(), envs.widths().1],
        }
    }
}

fn sampler(
    settings: Vec<b2b_env::vector::Setting>,
    any: bool,
    window: Option<(u32, u32)>,
) -> Box<dyn Sampler> {
    match (any, window) {
        (true, None) => Box::new(AnyOf(settings)),
        (false, None) => Box::new(Fixed(settings)),
        (true, Some((days, starts))) => Box::new(Windows { of: AnyOf(settings), days: (days, days), starts }),
        (false, Some((days, starts))) => {
            Box::new(Windows { of: Fixed(settings), days: (days, days), starts })
        }
    }
}
