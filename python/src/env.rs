//! An environment in its own process.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use b2b_env::Spaces as EnvSpaces;
use b2b_env::vector::{Live, Pool, Start, TemplateId};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::catalog::{Setting, locked};
use crate::error::{Exception, of_env};
use crate::pools::{self, Owner};
use crate::spaces::Spaces;
use crate::{arrays, control};

/// An environment: a pool of processes with one episode and its snapshots.
#[pyclass(frozen, module = "building2building._core")]
pub struct Env {
    owner: Owner,
    state: Mutex<State>,
}

struct State {
    owner: Owner,
    /// `None` once closed.
    pool: Option<Pool>,
    setting: Setting,
    template: TemplateId,
    spaces: Arc<EnvSpaces>,
    live: Option<Live>,
    snapshots: HashMap<u64, Live>,
    next_snapshot: u64,
}

/// An observation as f32 and as f64.
pub type Seen<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f64>>);
/// The result of a step: observation as f32 and as f64, temperature and energy penalty, and whether it was the last.
pub type Stepped<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f64>>, f64, f64, bool);

#[pymethods]
impl Env {
    /// Prepares the building; the first time may take seconds for sizing and warm-up.
    #[new]
    fn new(py: Python<'_>, setting: &Setting) -> PyResult<Self> {
        let options = pools::options(py)?;
        let setting = setting.clone();
        let state = py.detach(|| -> PyResult<State> {
            let mut pool = Pool::new(options).map_err(of_env)?;
            let template = pool.prepare(&setting.setting).map_err(of_env)?;
            let spaces = pool.spaces(template).map_err(of_env)?;
            setting.building.keep(&spaces);
            Ok(State {
                owner: Owner::this(),
                pool: Some(pool),
                setting,
                template,
                spaces,
                live: None,
                snapshots: HashMap::new(),
                next_snapshot: 0,
            })
        })?;
        Ok(Self { owner: Owner::this(), state: Mutex::new(state) })
    }

    /// Returns the spaces.
    fn spaces(&self, py: Python<'_>) -> PyResult<Spaces> {
        self.owner.with(py, &self.state, |state| {
            Ok(Spaces::new(Arc::clone(&state.spaces), Arc::clone(&state.setting.building)))
        })
    }

    /// Changes the setting of future episodes and ends the one in progress.
    fn set_setting(&self, py: Python<'_>, setting: &Setting) -> PyResult<()> {
        let setting = setting.clone();
        self.owner.with(py, &self.state, |state| {
            let (pool, live) = state.parts()?;
            if let Some(live) = live.take() {
                pool.stop(live);
            }
            let template = pool.prepare(&setting.setting).map_err(of_env)?;
            let spaces = pool.spaces(template).map_err(of_env)?;
            setting.building.keep(&spaces);
            (state.template, state.spaces, state.setting) = (template, spaces, setting);
            Ok(())
        })
    }

    /// Begins an episode of `steps` steps, or of the whole run period.
    #[pyo3(signature = (steps=None))]
    fn reset<'py>(&self, py: Python<'py>, steps: Option<usize>) -> PyResult<Seen<'py>> {
        let observation = self.owner.with(py, &self.state, |state| state.reset(steps))?;
        Ok((arrays::single(py, &observation), arrays::row(py, &observation)))
    }

    /// Applies an action, in physical units or rescaled to [-1, 1], and runs one step.
    fn step<'py>(
        &self,
        py: Python<'py>,
        action: &Bound<'py, PyAny>,
        rescale: bool,
    ) -> PyResult<Stepped<'py>> {
        let mut action = arrays::numbers(action)?;
        let (observation, [temperature, energy], truncated) = self.owner.with(py, &self.state, |state| {
            if rescale {
                state.spaces.action.rescale(&mut action);
            }
            state.step(&action)
        })?;
        let single = arrays::single(py, &observation);
        Ok((single, arrays::row(py, &observation), temperature, energy, truncated))
    }

    /// Returns the last action as applied: clamped, in physical units.
    fn applied_action<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let action = self.owner.with(py, &self.state, |state| {
            let mut action = vec![0.0; state.spaces.action.len()];
            let (pool, live) = state.parts()?;
            let live = live.as_ref().ok_or_else(not_reset)?;
            pool.action(live, &mut action);
            Ok(action)
        })?;
        Ok(arrays::row(py, &action))
    }

    /// Returns the metrics of the episode, or `None` before its end.
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let metrics = self.owner.with(py, &self.state, |state| {
            let (pool, live) = state.parts()?;
            Ok(live.as_ref().and_then(|live| pool.metrics(live)))
        })?;
        metrics.map(|metrics| control::metrics(py, &metrics)).transpose()
    }

    /// Takes a snapshot of the episode and returns its number.
    fn snapshot(&self, py: Python<'_>) -> PyResult<u64> {
        self.owner.with(py, &self.state, |state| {
            let (pool, live) = state.parts()?;
            let live = live.as_ref().ok_or_else(not_reset)?;
            let copy = pool.snapshot(live).map_err(of_env)?;
            let copy = ready(pool, copy)?;
            state.next_snapshot += 1;
            state.snapshots.insert(state.next_snapshot, copy);
            Ok(state.next_snapshot)
        })
    }

    /// Restores a snapshot.
    fn restore(&self, py: Python<'_>, snapshot: u64) -> PyResult<()> {
        self.owner.with(py, &self.state, |state| {
            let pool = state.pool.as_mut().ok_or_else(closed)?;
            let kept = state.snapshots.get(&snapshot).ok_or_else(|| {
                Exception::Episode.new_err("this snapshot was released or belongs to another environment")
            })?;
            let copy = pool.snapshot(kept).map_err(of_env)?;
            let copy = ready(pool, copy)?;
            if let Some(live) = state.live.replace(copy) {
                pool.stop(live);
            }
            Ok(())
        })
    }

    /// Ends the process of a snapshot.
    fn release(&self, py: Python<'_>, snapshot: u64) -> PyResult<()> {
        if !self.owner.is_here() {
            return Ok(());
        }
        self.owner.with(py, &self.state, |state| {
            if let (Some(live), Some(pool)) = (state.snapshots.remove(&snapshot), state.pool.as_mut()) {
                pool.stop(live);
            }
            Ok(())
        })
    }

    /// Id of the process that runs the episode.
    #[getter]
    fn process(&self, py: Python<'_>) -> PyResult<Option<u32>> {
        self.owner.with(py, &self.state, |state| {
            Ok(state.live.as_ref().and_then(|live| state.pool.as_ref()?.process(live)))
        })
    }

    /// Ends all its processes.
    fn close(&self, py: Python<'_>) {
        if self.owner.is_here() {
            py.detach(|| {
                let mut state = locked(&self.state);
                (state.live, state.pool) = (None, None);
                state.snapshots.clear();
            });
        }
    }
}

impl State {
    fn parts(&mut self) -> PyResult<(&mut Pool, &mut Option<Live>)> {
        Ok((self.pool.as_mut().ok_or_else(closed)?, &mut self.live))
    }

    fn reset(&mut self, steps: Option<usize>) -> PyResult<Vec<f64>> {
        let pool = self.pool.as_mut().ok_or_else(closed)?;
        if let Some(live) = self.live.take() {
            pool.stop(live);
        }
        // The template is the same one unless it was evicted.
        self.template = pool.prepare(&self.setting.setting).map_err(of_env)?;
        let live = pool.begin(self.template, Start { steps, processor: None }).map_err(of_env)?;
        let live = ready(pool, live)?;
        let mut observation = vec![0.0; self.spaces.observation.len()];
        pool.observation(&live, &mut observation);
        self.live = Some(live);
        Ok(observation)
    }

    fn step(&mut self, action: &[f64]) -> PyResult<(Vec<f64>, [f64; 2], bool)> {
        let pool = self.pool.as_mut().ok_or_else(closed)?;
        let live = self.live.as_mut().ok_or_else(not_reset)?;
        if live.is_busy() {
            return Err(Exception::Episode.new_err("the last step was interrupted; call reset"));
        }
        pool.send(live, action).map_err(of_env)?;
        pool.wait(std::slice::from_mut(live), 1).map_err(of_env)?;
        alive(live)?;
        let mut observation = vec![0.0; self.spaces.observation.len()];
        pool.observation(live, &mut observation);
        let reward = pool.reward(live);
        Ok((observation, [reward.temperature_penalty, reward.energy_penalty], live.is_truncated()))
    }
}

impl Drop for State {
    /// A fork of the owner process leaves the worker processes alone.
    fn drop(&mut self) {
        if !self.owner.is_here() {
            std::mem::forget((self.pool.take(), self.live.take(), std::mem::take(&mut self.snapshots)));
        }
    }
}

/// Waits until a copy is ready, and stops it if it fails.
fn ready(pool: &mut Pool, mut live: Live) -> PyResult<Live> {
    let waited = pool.wait(std::slice::from_mut(&mut live), 1).map_err(of_env);
    match waited.and_then(|()| alive(&live)) {
        Ok(()) => Ok(live),
        Err(error) => {
            pool.stop(live);
            Err(error)
        }
    }
}

fn alive(live: &Live) -> PyResult<()> {
    match live.lost() {
        None => Ok(()),
        Some(why) => Err(Exception::Episode.new_err(format!("the episode was lost: {why}"))),
    }
}

fn closed() -> PyErr {
    Exception::Episode.new_err("the environment is closed")
}

fn not_reset() -> PyErr {
    Exception::Episode.new_err("no episode is in progress; call reset first")
}
