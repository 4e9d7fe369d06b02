//! Training of agents, and the description of an agent in its folder.

pub(crate) mod pilot;

use std::path::PathBuf;
use std::sync::Mutex;

use b2b_agent::Agent;
use b2b_learn::ComfortWeights;
use b2b_learn::train::{Monitor, ProgressRow, RunOptions, TrainConfig};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use crate::buildings::catalog;
use crate::evaluation::{running, wait_for};
use crate::interpreter::error::{of_agent, of_training};
use crate::interpreter::process::locked;
use crate::interpreter::signals::stopped;

/// Returns the weight of discomfort after an evaluation, given the weight before, and the discomfort of the policy and of
/// the baseline, K·h per zone and day.
#[pyfunction]
pub fn next_comfort_weight(weight: f32, reached: f64, allowed: f64) -> f32 {
    ComfortWeights::next(weight, reached, allowed, 1.0)
}

/// Trains an agent in a folder, or resumes the run in the folder, and returns the result as JSON text.
///
/// `options` is a JSON object with options of a run's `config.toml`; with `resume`, only `steps`. `config` is a TOML
/// file with such options, which `options` override; `preset` is the preset that both modify, by default the one for
/// these options. `callback` is called with
/// a dictionary after every update; if it returns `False`, the run ends with a checkpoint. `stage` is called with a
/// text before other work.
#[pyfunction]
#[pyo3(signature = (options, out, jobs, resume, preset=None, config=None, callback=None, stage=None))]
#[expect(clippy::too_many_arguments, reason = "the Python function passes them by name")]
pub fn train(
    py: Python<'_>,
    options: &str,
    out: PathBuf,
    jobs: usize,
    resume: bool,
    preset: Option<&str>,
    config: Option<PathBuf>,
    callback: Option<Py<PyAny>>,
    stage: Option<Py<PyAny>>,
) -> PyResult<String> {
    let _running = running()?;
    let config = match resume {
        true => TrainConfig::of_run(&out).and_then(|base| base.with_json(options)),
        false => TrainConfig::of_json(options, preset, config.as_deref()),
    };
    let config = config.map_err(of_training)?;
    let launcher = catalog::worker_options(py)?.launcher;
    let events = Events::default();
    let raised = Mutex::new(None);
    let listener = Listener { callback, stage };
    let outcome = py.detach(|| {
        let catalog = catalog::catalog()?;
        let options =
            RunOptions { out, catalog, launcher, jobs, interrupted: stopped, monitor: &mut &events };
        let trained = wait_for(
            || b2b_learn::train::train(&config, options),
            || listener.report(std::mem::take(&mut *locked(&events.0)), &raised),
            of_training,
        );
        // Checked even after a complete run, because the callback may have raised at the last update.
        locked(&raised).take().map_or(trained, Err)
    });
    Ok(serde_json::to_string(&outcome?).expect("a summary is plain data"))
}

/// Returns the description of an agent as JSON text.
#[pyfunction]
pub fn agent_info(folder: PathBuf) -> PyResult<String> {
    let agent = Agent::read(&folder).map_err(of_agent)?;
    Ok(serde_json::to_string(agent.info()).expect("plain data always serializes"))
}

/// Events that have not been passed to Python yet.
#[derive(Default)]
struct Events(Mutex<Vec<Event>>);

enum Event {
    /// The run began work other than updates.
    Stage(String),
    /// An update.
    Update(ProgressRow),
}

impl Monitor for &Events {
    fn stage(&mut self, what: &str) {
        locked(&self.0).push(Event::Stage(what.to_owned()));
    }

    fn update(&mut self, row: &ProgressRow) {
        locked(&self.0).push(Event::Update(row.clone()));
    }

    fn warn(&mut self, text: &str) {
        eprintln!("warning: {text}");
    }
}

/// Python functions called as a run proceeds.
struct Listener {
    callback: Option<Py<PyAny>>,
    stage: Option<Py<PyAny>>,
}

impl Listener {
    /// Passes events on and returns whether to continue.
    fn report(&self, events: Vec<Event>, raised: &Mutex<Option<PyErr>>) -> bool {
        if events.is_empty() {
            return true;
        }
        Python::attach(|py| {
            let mut continues = true;
            for event in events {
                match self.pass(py, event) {
                    Ok(answer) => continues &= answer,
                    Err(error) => {
                        locked(raised).get_or_insert(error);
                        continues = false;
                    }
                }
            }
            continues
        })
    }

    fn pass(&self, py: Python<'_>, event: Event) -> PyResult<bool> {
        match (event, &self.callback, &self.stage) {
            (Event::Stage(what), _, Some(stage)) => {
                stage.call1(py, (what,))?;
                Ok(true)
            }
            (Event::Update(row), Some(callback), _) => {
                let numbers = PyDict::new(py);
                numbers.set_item("steps", row.steps)?;
                for (name, value) in row.values {
                    numbers.set_item(name, value)?;
                }
                let answer = callback.call1(py, (numbers,))?;
                Ok(!answer.bind(py).is(PyBool::new(py, false)))
            }
            _ => Ok(true),
        }
    }
}
