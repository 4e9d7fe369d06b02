//! An environment in its own process.

pub(crate) mod local;
pub(crate) mod owner;
pub(crate) mod record;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use b2b_env::{Environment, InfoNumbers, to_info_numbers};
use b2b_workers::{Episode, EpisodeOptions, Snapshot, Workers};
use numpy::PyArray1;
use pyo3::prelude::*;

use self::record::Record;
use crate::buildings::catalog;
use crate::buildings::catalog::Setting;
use crate::control;
use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_env};
use crate::interpreter::process::{OwnerProcess, locked};
use crate::spaces::Spaces;

/// An environment: worker processes with one episode and its snapshots.
#[pyclass(frozen, module = "building2building._core")]
pub struct Env {
    owner: OwnerProcess,
    state: Mutex<State>,
}

struct State {
    setting: Setting,
    /// `None` once closed.
    open: Option<Open>,
    next_snapshot: u64,
}

/// The processes of an environment.
struct Open {
    workers: Workers,
    episode: Episode,
    snapshots: HashMap<u64, Snapshot>,
}

/// An observation as f32 and as f64.
pub type Observations<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f64>>);
/// The result of a step: observation as f32 and as f64, numbers of the info, and truncation.
pub type Stepped<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f64>>, InfoNumbers, bool);

#[pymethods]
impl Env {
    /// Prepares the building; on first use, sizing and warm-up may take seconds.
    #[new]
    fn new(py: Python<'_>, setting: &Setting) -> PyResult<Self> {
        let options = catalog::worker_options(py)?;
        let setting = setting.clone();
        let state = py.detach(|| -> PyResult<State> {
            let workers = Workers::new(options).map_err(of_env)?;
            let episode = workers.episode(&setting.setting).map_err(of_env)?;
            setting.building.keep(episode.spaces());
            let open = Open { workers, episode, snapshots: HashMap::new() };
            Ok(State { setting, open: Some(open), next_snapshot: 0 })
        })?;
        Ok(Self { owner: OwnerProcess::this(), state: Mutex::new(state) })
    }

    /// Returns the spaces.
    fn spaces(&self, py: Python<'_>) -> PyResult<Spaces> {
        self.owner.with(py, &self.state, |state| {
            let building = Arc::clone(&state.setting.building);
            Ok(Spaces::new(Arc::clone(state.open()?.episode.spaces()), building))
        })
    }

    /// Changes the setting of future episodes and ends the one in progress.
    fn set_setting(&self, py: Python<'_>, setting: &Setting) -> PyResult<()> {
        let setting = setting.clone();
        self.owner.with(py, &self.state, |state| {
            let open = state.open()?;
            open.episode = open.workers.episode(&setting.setting).map_err(of_env)?;
            setting.building.keep(open.episode.spaces());
            state.setting = setting;
            Ok(())
        })
    }

    /// Starts an episode of `steps` steps, or of the whole run period. With `finish_run`, the engine finishes its run
    /// after the episode, so that [`Env::record`] has its report.
    #[pyo3(signature = (steps=None, finish_run=false))]
    fn reset<'py>(
        &self,
        py: Python<'py>,
        steps: Option<usize>,
        finish_run: bool,
    ) -> PyResult<Observations<'py>> {
        let observation = self.owner.with(py, &self.state, |state| {
            let episode = &mut state.open()?.episode;
            episode.set_options(EpisodeOptions { max_steps: steps, processor: None, finish_run });
            Ok(episode.reset().map_err(of_env)?.to_vec())
        })?;
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
        let (observation, numbers, truncated) = self.owner.with(py, &self.state, |state| {
            let episode = &mut state.open()?.episode;
            if rescale {
                episode.spaces().action.rescale(&mut action);
            }
            let step = episode.step(&action).map_err(of_env)?;
            Ok((step.observation.to_vec(), to_info_numbers(step.reward, &step.terms), step.truncated))
        })?;
        let single = arrays::single(py, &observation);
        Ok((single, arrays::row(py, &observation), numbers, truncated))
    }

    /// Returns the last action as applied: clamped, in physical units.
    fn applied_action<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let action = self.owner.with(py, &self.state, |state| {
            Ok(state.open()?.episode.last_step().map_err(of_env)?.action.to_vec())
        })?;
        Ok(arrays::row(py, &action))
    }

    /// Returns the metrics of the episode, or `None` before its end.
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let metrics =
            self.owner.with(py, &self.state, |state| Ok(state.open()?.episode.metrics().cloned()))?;
        metrics.map(|metrics| control::metrics(py, &metrics)).transpose()
    }

    /// Returns the spaces and metrics of the episode, for writing its files.
    fn record(&self, py: Python<'_>) -> PyResult<Record> {
        self.owner.with(py, &self.state, |state| {
            let place = state.setting.building.place().to_owned();
            let episode = &state.open()?.episode;
            let (metrics, report) = (episode.metrics().cloned(), episode.report().cloned());
            Ok(Record { spaces: Arc::clone(episode.spaces()), place, metrics, report })
        })
    }

    /// Takes a snapshot of the episode and returns its number.
    fn snapshot(&self, py: Python<'_>) -> PyResult<u64> {
        self.owner.with(py, &self.state, |state| {
            let number = state.next_snapshot + 1;
            let open = state.open()?;
            open.snapshots.insert(number, open.episode.snapshot().map_err(of_env)?);
            state.next_snapshot = number;
            Ok(number)
        })
    }

    /// Restores a snapshot.
    fn restore(&self, py: Python<'_>, snapshot: u64) -> PyResult<()> {
        self.owner.with(py, &self.state, |state| {
            let open = state.open()?;
            let kept = open.snapshots.get(&snapshot).ok_or_else(|| {
                Exception::Episode.new_err("this snapshot was released or belongs to another environment")
            })?;
            open.episode = kept.episode().map_err(of_env)?;
            Ok(())
        })
    }

    /// Returns `count` environments that continue from the current point of the episode.
    fn branch(&self, py: Python<'_>, count: usize) -> PyResult<Vec<Self>> {
        self.owner.with(py, &self.state, |state| {
            let setting = state.setting.clone();
            let open = state.open()?;
            let episodes = open.episode.branch(count).map_err(of_env)?;
            let branch = |episode| {
                let open = Open { workers: open.workers.clone(), episode, snapshots: HashMap::new() };
                let state = State { setting: setting.clone(), open: Some(open), next_snapshot: 0 };
                Self { owner: OwnerProcess::this(), state: Mutex::new(state) }
            };
            Ok(episodes.into_iter().map(branch).collect())
        })
    }

    /// Ends the process of a snapshot.
    fn release(&self, py: Python<'_>, snapshot: u64) -> PyResult<()> {
        if !self.owner.is_current() {
            return Ok(());
        }
        self.owner.with(py, &self.state, |state| {
            if let Some(open) = &mut state.open {
                open.snapshots.remove(&snapshot);
            }
            Ok(())
        })
    }

    /// Id of the process that runs the episode.
    #[getter]
    fn process(&self, py: Python<'_>) -> PyResult<Option<u32>> {
        self.owner
            .with(py, &self.state, |state| Ok(state.open.as_ref().and_then(|open| open.episode.process())))
    }

    /// Ends the processes of the environment and its snapshots.
    fn close(&self, py: Python<'_>) {
        if self.owner.is_current() {
            py.detach(|| locked(&self.state).open = None);
        }
    }
}

impl State {
    fn open(&mut self) -> PyResult<&mut Open> {
        self.open.as_mut().ok_or_else(|| Exception::Episode.new_err("the environment is closed"))
    }
}
