//! Training of agents, and the description of an agent in its folder.

use std::path::PathBuf;
use std::sync::Mutex;

use b2b_agent::Agent;
use b2b_learn::train::{Monitor, Row, RunOptions, TrainConfig};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::catalog::{self, locked};
use crate::error::{of_agent, of_training};
use crate::evaluation::{running, stopped, wait_for};
use crate::pools;

/// Trains an agent in a folder, or resumes the run in the folder, and returns the result as JSON text.
///
/// `options` is a JSON object with options of a run's `config.toml`, and `preset`; with `resume`, only `steps`.
/// `callback` is called with a dictionary after every update. If it returns `False`, the run ends with a checkpoint.
#[pyfunction]
#[pyo3(signature = (options, out, jobs, resume, callback=None))]
pub fn train(
    py: Python<'_>,
    options: &str,
    out: PathBuf,
    jobs: usize,
    resume: bool,
    callback: Option<Py<PyAny>>,
) -> PyResult<String> {
    let _running = running()?;
    let base = if resume { TrainConfig::of_run(&out) } else { TrainConfig::preset("residual") };
    let config = base.and_then(|base| base.with_json(options)).map_err(of_training)?;
    let launcher = pools::options(py)?.launcher;
    let updates = Updates::default();
    let raised = Mutex::new(None);
    let outcome = py.detach(|| {
        let catalog = catalog::catalog()?;
        let options = RunOptions { out, catalog, launcher, jobs, interrupted: stopped, monitor: &mut &updates };
        let trained = wait_for(
            || b2b_learn::train::train(&config, options),
            || report(std::mem::take(&mut *locked(&updates.0)), callback.as_ref(), &raised),
        );
        // Also of a run that has ended: the callback may have raised at its last update.
        let exception = locked(&raised).take();
        exception.map_or_else(|| trained.map_err(of_training), Err)
    });
    Ok(serde_json::to_string(&outcome?).expect("a summary is plain data"))
}

/// Returns the description of an agent as JSON text.
#[pyfunction]
pub fn agent_info(folder: PathBuf) -> PyResult<String> {
    let agent = Agent::read(&folder).map_err(of_agent)?;
    Ok(serde_json::to_string(agent.info()).expect("plain data always serializes"))
}

/// Updates that have not been passed to the callback yet.
#[derive(Default)]
struct Updates(Mutex<Vec<Row>>);

impl Monitor for &Updates {
    fn update(&mut self, row: &Row) {
        locked(&self.0).push(row.clone());
    }

    fn warn(&mut self, text: &str) {
        eprintln!("warning: {text}");
    }
}

/// Calls the callback with updates and returns whether to continue.
fn report(updates: Vec<Row>, callback: Option<&Py<PyAny>>, raised: &Mutex<Option<PyErr>>) -> bool {
    let Some(callback) = callback.filter(|_| !updates.is_empty()) else { return true };
    Python::attach(|py| {
        let call = |row: Row| -> PyResult<bool> {
            let numbers = PyDict::new(py);
            numbers.set_item("steps", row.steps)?;
            for (name, value) in row.values {
                numbers.set_item(name, value)?;
            }
            let answer = callback.call1(py, (numbers,))?;
            Ok(!answer.bind(py).is(pyo3::types::PyBool::new(py, false)))
        };
        let mut continues = true;
        for row in updates {
            match call(row) {
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
