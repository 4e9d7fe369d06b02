//! Evaluation of a policy, built in or written in Python, on many buildings.

pub(crate) mod benchmarks;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::time::Duration;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{ArrayRef, RecordBatch};
use b2b_climate::Place;
use b2b_control::Controller;
use b2b_dataset::Placement;
use b2b_energyplus::install::{Quiet, cache_dir};
use b2b_env::ActionSpace;
use b2b_evaluate::{
    ActionScale, Baselines, EpisodeContext, EpisodePlan, Evaluation, Folder, Policy, Progress, Results,
    Subject, episode_table, run_part,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::buildings::catalog::{self, Building, Inner};
use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_building, of_evaluation};
use crate::interpreter::process::locked;
use crate::interpreter::signals::{interrupted, set_stopped, stopped, take_raised};
use crate::spaces::Spaces;

/// Interval at which signals are handled and progress is reported.
const LOOK: Duration = Duration::from_millis(50);

/// Lock that the running evaluation, training or calibration holds.
static RUNNING: Mutex<()> = Mutex::new(());

/// An episode to run: building, place, weather, allow_external, control, keep_design_days, task, run period, seed and
/// steps per hour.
type EpisodeKey =
    (String, Option<String>, Option<PathBuf>, bool, Option<String>, bool, String, String, u64, u32);

/// A policy and the episodes that it runs: an object of the package with these attributes.
///
/// `policy` is the name of a built-in policy, the folder of an agent, the path of an ONNX file (actions in [-1, 1] if
/// `rescale`), or a callable that takes spaces, building and seed and returns the controller of an episode; `name` and
/// `identity` describe the callable.
#[derive(FromPyObject)]
pub struct Request<'py> {
    policy: Bound<'py, PyAny>,
    /// A list of [`EpisodeKey`].
    episodes: Bound<'py, PyAny>,
    rescale: bool,
    name: String,
    identity: String,
}

impl Request<'_> {
    /// Calls `run` with the policy and the episodes, like [`run_policy`].
    fn run<T: Send>(
        self,
        py: Python<'_>,
        jobs: usize,
        progress: Option<&Py<PyAny>>,
        run: impl FnOnce(&Evaluation<'_>, &dyn Policy, &[EpisodePlan], &Counter) -> b2b_evaluate::Result<T> + Send,
    ) -> PyResult<T> {
        let _running = running()?;
        let keys: Vec<EpisodeKey> = self.episodes.extract()?;
        let episodes = keys.into_iter().map(episode).collect::<PyResult<Vec<_>>>()?;
        let raised = Arc::new(Mutex::new(None));
        let policy = self.into_policy(&raised)?;
        let policy = policy.as_ref();
        run_policy(py, jobs, &raised, progress, |evaluation, counter| {
            run(evaluation, policy, &episodes, counter)
        })
    }

    /// Returns the policy, which is a name, a path or a Python callable.
    fn into_policy(self, raised: &Arc<Mutex<Option<PyErr>>>) -> PyResult<Box<dyn Policy>> {
        let Self { policy, rescale, name, identity, .. } = self;
        if let Ok(name) = policy.extract::<String>() {
            let scale = if rescale { ActionScale::Rescaled } else { ActionScale::Physical };
            return <dyn Policy>::named(&name, scale).map_err(of_evaluation);
        }
        let (make, raised) = (policy.unbind(), Arc::clone(raised));
        Ok(Box::new(InPython { name, identity, make, rescale, whole: true, has_memory: false, raised }))
    }
}

/// Runs a policy on episodes and returns the columns of their table, the summary as JSON text, and the number of
/// episodes that were in the folder already, which are not run again. `progress` is called regularly with a label, the
/// simulated days and their total.
#[pyfunction]
#[pyo3(signature = (request, folder, jobs, progress=None))]
pub fn evaluate<'py>(
    py: Python<'py>,
    request: Request<'py>,
    folder: PathBuf,
    jobs: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, String, usize)> {
    let run = request.run(py, jobs, progress.as_ref(), |evaluation, policy, episodes, counter| {
        let folder = Folder::open(&folder, policy, episodes)?;
        let reused = (0..episodes.len()).filter(|number| folder.read(*number).is_some()).count();
        let results = Results::of(evaluation, &folder, episodes, policy, &Baselines::open()?, counter)?;
        if stopped() {
            // The last episode may have ended in an exception.
            return Err(b2b_evaluate::Error::Interrupted);
        }
        let summary = results.summary(policy);
        results.write(&folder, &summary)?;
        Ok((results, summary, reused))
    });
    let (results, summary, reused) = run?;
    let table = episode_table(&results.rows, &summary.versions);
    let table = table.map_err(|error| Exception::Evaluation.new_err(error.to_string()))?;
    let summary = serde_json::to_string(&summary).expect("a summary is plain data");
    Ok((columns(py, &table)?, summary, reused))
}

/// Runs a part of the work of [`evaluate`]: the episodes with the given numbers, one at a time, and their baselines if
/// unknown. Writes episodes to `folder` and baselines to the folder `baselines`. Returns the reasons for lost episodes,
/// by number.
#[pyfunction]
pub fn evaluate_part(
    py: Python<'_>,
    request: Request<'_>,
    folder: PathBuf,
    numbers: Vec<usize>,
    baselines: PathBuf,
) -> PyResult<HashMap<usize, String>> {
    let lost = request.run(py, 1, None, |evaluation, policy, episodes, counter| {
        let part: Vec<_> =
            episodes.iter().enumerate().filter(|(number, _)| numbers.contains(number)).collect();
        let folder = Folder::open(&folder, policy, episodes)?;
        run_part(evaluation, &folder, &part, policy, &Baselines::in_folder(&baselines), counter)
    })?;
    Ok(lost.into_iter().map(|(number, lost)| (number, lost.reason)).collect())
}

/// Returns the folder of the baselines computed on this machine.
#[pyfunction]
pub fn baselines_folder() -> PyResult<PathBuf> {
    let cache = cache_dir().map_err(of_evaluation)?;
    Ok(Baselines::folder_in(&cache))
}

/// Returns the return of the reactive controllers in an episode, their HVAC energy (Wh/m²) and the number of steps.
/// Runs the episode if its baseline is unknown. Raises for a task of operation, whose score is not a ratio of returns.
#[pyfunction]
pub fn baseline(py: Python<'_>, episode: EpisodeKey) -> PyResult<(f64, f64, u64)> {
    let _running = running()?;
    let episode = self::episode(episode)?;
    if episode.task.is_operation() {
        let message = format!(
            "task `{}` is scored by cost at comfort, which does not follow from a return; call evaluate, or \
             trajectory.write and `b2b score`",
            episode.task
        );
        return Err(Exception::Setting.new_err(message));
    }
    let launcher = catalog::worker_options(py)?.launcher;
    let counter = Counter::default();
    py.detach(|| {
        let catalog = catalog::catalog()?;
        let run = || {
            let evaluation = Evaluation { catalog: &catalog, launcher, jobs: 1, interrupted: stopped };
            let site = episode.subject.locate(&catalog, &mut Quiet)?;
            Baselines::open()?.baseline(&evaluation, &episode, &site, &counter)
        };
        let baseline = wait_for(run, || true, of_evaluation)?;
        Ok((baseline.episode_return, baseline.energy, episode.steps()))
    })
}

/// Runs episodes of a policy while handling signals and reporting progress. An exception raised by the policy takes
/// precedence over the error that results from it.
pub fn run_policy<T: Send>(
    py: Python<'_>,
    jobs: usize,
    raised: &Mutex<Option<PyErr>>,
    progress: Option<&Py<PyAny>>,
    run: impl FnOnce(&Evaluation<'_>, &Counter) -> b2b_evaluate::Result<T> + Send,
) -> PyResult<T> {
    let launcher = catalog::worker_options(py)?.launcher;
    let counter = Counter::default();
    py.detach(|| {
        let catalog = catalog::catalog()?;
        let run = || run(&Evaluation { catalog: &catalog, launcher, jobs, interrupted: stopped }, &counter);
        let outcome = wait_for(run, || counter.report(progress), of_evaluation);
        // Even if the run has ended, because the policy may have raised in its last episode.
        locked(raised).take().map_or(outcome, Err)
    })
}

/// Locks the process for one evaluation, training or calibration. Errors if another one is running.
pub fn running() -> PyResult<MutexGuard<'static, ()>> {
    let one_at_a_time = || {
        Exception::Process
            .new_err("an evaluation, a training or a calibration is already running in this process; wait until it ends")
    };
    let running = match RUNNING.try_lock() {
        Ok(running) => running,
        // The lock is poisoned by an evaluation that panicked and thus has ended.
        Err(TryLockError::Poisoned(over)) => over.into_inner(),
        Err(TryLockError::WouldBlock) => return Err(one_at_a_time()),
    };
    set_stopped(false);
    Ok(running)
}

/// Calls `run` on another thread while this one handles signals and calls `report`, which returns whether to continue.
/// The last call of `report` is after the end of `run`. An exception raised by a signal handler takes precedence over
/// the outcome.
pub fn wait_for<T: Send, E: Send>(
    run: impl FnOnce() -> Result<T, E> + Send,
    mut report: impl FnMut() -> bool,
    of_error: impl FnOnce(E) -> PyErr,
) -> PyResult<T> {
    std::thread::scope(|scope| {
        let waiting = std::thread::current();
        let running = scope.spawn(move || {
            let outcome = run();
            waiting.unpark();
            outcome
        });
        while !running.is_finished() {
            std::thread::park_timeout(LOOK);
            if interrupted() || !report() {
                set_stopped(true);
            }
        }
        report();
        let outcome = running.join();
        set_stopped(false);
        let outcome = outcome.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        take_raised().map_or_else(|| outcome.map_err(of_error), Err)
    })
}

fn episode(key: EpisodeKey) -> PyResult<EpisodePlan> {
    let (name, place, weather, allow_external, control, keep_design_days, task, period, seed, steps_per_hour) =
        key;
    let place = place.as_deref().map(Place::find).transpose().map_err(of_building)?;
    let name = name.parse().map_err(of_building)?;
    let control = catalog::read_control(control.as_deref())?;
    Ok(EpisodePlan {
        subject: Subject {
            name,
            placement: Placement {
                place,
                weather,
                allow_external,
                control,
                keep_design_days,
                transition: None,
            },
        },
        task: catalog::read_task(&task)?,
        period: period.parse().map_err(of_building)?,
        seed,
        steps_per_hour,
    })
}

/// A policy written in Python.
pub struct InPython {
    pub name: String,
    pub identity: String,
    /// Takes spaces, building and seed and returns the controller of an episode, or of consecutive episodes in a
    /// building.
    pub make: Py<PyAny>,
    /// Whether actions are in [-1, 1].
    pub rescale: bool,
    /// Whether it observes and controls the whole building instead of the problem's interface.
    pub whole: bool,
    /// Whether its controllers have the method `next_episode`.
    pub has_memory: bool,
    /// The first exception that it raised.
    pub raised: Arc<Mutex<Option<PyErr>>>,
}

impl Policy for InPython {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn ignores_interface(&self) -> bool {
        self.whole
    }

    fn has_memory(&self) -> bool {
        self.has_memory
    }

    fn controller(&self, context: EpisodeContext<'_>) -> b2b_evaluate::Result<Box<dyn Controller>> {
        let EpisodeContext { subject, site, spaces, interface, seed, .. } = context;
        let building = Arc::new(Inner::of_subject(subject, site, spaces));
        let made: PyResult<_> = Python::attach(|py| {
            let seen = Spaces::new(Arc::clone(spaces), Arc::clone(&building));
            let act = self.make.call1(py, (seen, Building { inner: building }, seed))?;
            let method = |name: &str| Ok::<_, PyErr>(act.bind(py).getattr_opt(name)?.map(Bound::unbind));
            let (next_episode, reward) = (method("next_episode")?, method("reward")?);
            Ok((act, next_episode, reward))
        });
        let (act, next_episode, reward) = made.map_err(|error| {
            fail(&self.raised, error);
            b2b_evaluate::Error::Interrupted
        })?;
        let space = if self.whole { &spaces.action } else { &interface.action };
        let (space, raised) = (space.clone(), Arc::clone(&self.raised));
        Ok(Box::new(Acting { act, next_episode, reward, space, rescale: self.rescale, raised }))
    }
}

/// The controller of one episode of a policy written in Python, or of consecutive episodes.
struct Acting {
    act: Py<PyAny>,
    /// Its methods of these names, if it has them.
    next_episode: Option<Py<PyAny>>,
    reward: Option<Py<PyAny>>,
    space: ActionSpace,
    rescale: bool,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Acting {
    fn ask(&self, observation: &[f64], action: &mut [f64]) -> PyResult<()> {
        Python::attach(|py| {
            let given = self.act.call1(py, (arrays::row(py, observation),))?;
            let given = arrays::numbers(given.bind(py))?;
            self.space.check(&given).map_err(crate::interpreter::error::of_env)?;
            action.copy_from_slice(&given);
            if self.rescale {
                self.space.rescale(action);
            }
            Ok(())
        })
    }

    /// Keeps an exception of a method, which ends the evaluation.
    fn keep(&self, called: PyResult<Option<Py<PyAny>>>) {
        if let Err(error) = called {
            fail(&self.raised, error);
        }
    }
}

impl Controller for Acting {
    /// Does nothing: a controller is made for its first episode.
    fn reset(&mut self) {}

    fn next_episode(&mut self) {
        let method = self.next_episode.as_ref();
        self.keep(Python::attach(|py| method.map(|method| method.call0(py)).transpose()));
    }

    fn reward(&mut self, reward: f64) {
        // Most policies have no such method, and the interpreter has one lock.
        if let Some(method) = &self.reward {
            self.keep(Python::attach(|py| method.call1(py, (reward,)).map(Some)));
        }
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        if let Err(error) = self.ask(observation, action) {
            // The environment rejects NaN, and the evaluation ends with the exception.
            action.fill(f64::NAN);
            fail(&self.raised, error);
        }
    }
}

/// Keeps the first exception and ends the evaluation.
fn fail(raised: &Mutex<Option<PyErr>>, error: PyErr) {
    locked(raised).get_or_insert(error);
    set_stopped(true);
}

/// Progress in simulated days.
#[derive(Default)]
pub struct Counter {
    what: Mutex<String>,
    done: AtomicU64,
    all: AtomicU64,
}

impl Progress for Counter {
    fn begin(&self, what: &str, _episodes: usize, days: u64) {
        what.clone_into(&mut locked(&self.what));
        self.done.store(0, Ordering::Relaxed);
        self.all.store(days, Ordering::Relaxed);
    }

    fn day(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

impl Counter {
    /// Calls the progress function and returns whether it succeeded.
    fn report(&self, progress: Option<&Py<PyAny>>) -> bool {
        let Some(progress) = progress else { return true };
        let what = locked(&self.what).clone();
        let (done, all) = (self.done.load(Ordering::Relaxed), self.all.load(Ordering::Relaxed));
        Python::attach(|py| progress.call1(py, (what, done, all)).is_ok())
    }
}

/// Returns the columns of a table as lists, by name.
fn columns<'py>(py: Python<'py>, table: &RecordBatch) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for (field, column) in table.schema().fields().iter().zip(table.columns()) {
        let values = if let Some(texts) = column.as_string_opt::<i32>() {
            PyList::new(py, texts)?
        } else if let Some(numbers) = column.as_primitive_opt::<Float64Type>() {
            PyList::new(py, numbers)?
        } else if let Some(numbers) = column.as_primitive_opt::<UInt64Type>() {
            PyList::new(py, numbers)?
        } else if let Some(lists) = column.as_list_opt::<i32>() {
            let counts = |list: Option<ArrayRef>| Some(list?.as_primitive::<UInt32Type>().values().to_vec());
            PyList::new(py, lists.iter().map(counts))?
        } else {
            PyList::new(py, column.as_primitive::<UInt32Type>())?
        };
        columns.set_item(field.name(), values)?;
    }
    Ok(columns)
}
