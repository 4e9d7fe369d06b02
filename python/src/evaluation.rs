//! A policy on many buildings: the crates' evaluation, under a policy of theirs or one in Python.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use b2b_benchmark::{
    ActionScale, Baselines, Episode, EpisodeContext, Evaluation, Folder, Policy, Progress, Results, Subject,
    episode_table, normalized_score,
};
use b2b_climate::Place;
use b2b_control::Controller;
use b2b_dataset::Placement;
use b2b_energyplus::install::Quiet;
use b2b_env::ActionSpace;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::arrays;
use crate::catalog::{self, Building, Inner, locked};
use crate::error::{of_benchmark, of_building, raise};
use crate::pools;
use crate::spaces::Spaces;

/// How often whoever waits for an evaluation sees to signals.
const LOOK: Duration = Duration::from_millis(50);

/// Ends the evaluation that runs: Ctrl-C, or an exception of the policy.
static STOP: AtomicBool = AtomicBool::new(false);
/// Held by the evaluation that runs.
static RUNNING: Mutex<()> = Mutex::new(());

fn stopped() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// An episode to run: name, place, weather, task, run period, seed, steps an hour.
type Asked = (String, Option<String>, Option<PathBuf>, String, String, u64, u32);

/// Runs a policy on episodes, and gives the columns of their table and the summary as JSON. What the folder holds already
/// is not run again.
///
/// `policy` is the name of one of the crates' or an ONNX file, whose numbers are from -1 to 1 if `rescale`; or it makes, for
/// each episode, what acts in it: it is called with spaces, building and seed. `name` and `identity` are those of such a
/// policy. `progress` is called now and then with what runs, and how many days are done of how many.
#[pyfunction]
#[pyo3(signature = (policy, episodes, folder, jobs, rescale, name, identity, progress=None))]
#[allow(clippy::too_many_arguments, reason = "one call of one function of the package")]
pub fn evaluate<'py>(
    py: Python<'py>,
    policy: Bound<'py, PyAny>,
    episodes: Vec<Asked>,
    folder: PathBuf,
    jobs: usize,
    rescale: bool,
    name: String,
    identity: String,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let _running = running()?;
    let episodes = episodes.into_iter().map(episode).collect::<PyResult<Vec<_>>>()?;
    let raised = Arc::new(Mutex::new(None));
    let policy: Box<dyn Policy> = match policy.extract::<String>() {
        Ok(name) => {
            let scale = if rescale { ActionScale::Rescaled } else { ActionScale::Physical };
            <dyn Policy>::named(&name, scale).map_err(of_benchmark)?
        }
        Err(_) => {
            let make = policy.unbind();
            Box::new(InPython { name, identity, make, rescale, raised: Arc::clone(&raised) })
        }
    };
    let policy = policy.as_ref();
    let launcher = pools::options(py)?.launcher;
    let counter = Counter::default();
    let outcome = py.detach(|| {
        let catalog = catalog::catalog()?;
        let run = || -> b2b_benchmark::Result<_> {
            let evaluation = Evaluation { catalog: &catalog, launcher, jobs, interrupted: stopped };
            let folder = Folder::open(&folder, policy, &episodes)?;
            let baselines = Baselines::open()?;
            let results = Results::of(&evaluation, &folder, &episodes, policy, &baselines, &counter)?;
            if stopped() {
                // The last episode may have been lost to an exception.
                return Err(b2b_benchmark::Error::Interrupted);
            }
            let summary = results.summary(policy);
            results.write(&folder, &summary)?;
            Ok((results, summary))
        };
        wait_for(run, &counter, progress.as_ref())
            .map_err(|error| locked(&raised).take().unwrap_or_else(|| of_benchmark(error)))
    });
    let (results, summary) = outcome?;
    let table = episode_table(&results.rows, &summary.versions);
    let table = table.map_err(|error| raise("EvaluationError", error.to_string()))?;
    let summary = serde_json::to_string(&summary).expect("a summary is plain data");
    Ok((columns(py, &table)?, summary))
}

/// An episode's return over that of the reactive controllers, which run now if theirs is not known.
#[pyfunction]
pub fn compute_normalized_score(
    py: Python<'_>,
    episode_return: f64,
    episode: Asked,
) -> PyResult<Option<f64>> {
    let _running = running()?;
    let episode = self::episode(episode)?;
    let launcher = pools::options(py)?.launcher;
    let counter = Counter::default();
    py.detach(|| {
        let catalog = catalog::catalog()?;
        let run = || {
            let evaluation = Evaluation { catalog: &catalog, launcher, jobs: 1, interrupted: stopped };
            let surroundings = episode.subject.locate(&catalog, &mut Quiet)?;
            Baselines::open()?.episode_return(&evaluation, &episode, &surroundings, &counter)
        };
        let baseline_return = wait_for(run, &counter, None).map_err(of_benchmark)?;
        Ok(normalized_score(episode_return, baseline_return))
    })
}

/// Takes the one place of an evaluation in this process.
fn running() -> PyResult<MutexGuard<'static, ()>> {
    let one_at_a_time =
        || raise("ProcessError", "an evaluation runs in this process: wait for its end".into());
    let running = RUNNING.try_lock().map_err(|_| one_at_a_time())?;
    STOP.store(false, Ordering::Relaxed);
    Ok(running)
}

/// Runs on another thread, and sees to signals and progress on this one.
fn wait_for<T: Send>(
    run: impl FnOnce() -> b2b_benchmark::Result<T> + Send,
    counter: &Counter,
    progress: Option<&Py<PyAny>>,
) -> b2b_benchmark::Result<T> {
    std::thread::scope(|scope| {
        let waiting = std::thread::current();
        let running = scope.spawn(move || {
            let outcome = run();
            waiting.unpark();
            outcome
        });
        while !running.is_finished() {
            std::thread::park_timeout(LOOK);
            if pools::interrupted() || !counter.tell(progress) {
                STOP.store(true, Ordering::Relaxed);
            }
        }
        running.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn episode((name, place, weather, task, period, seed, steps_per_hour): Asked) -> PyResult<Episode> {
    let place = place.as_deref().map(Place::find).transpose().map_err(of_building)?;
    let name = name.parse().map_err(of_building)?;
    Ok(Episode {
        subject: Subject { name, placement: Placement { place, weather } },
        task: catalog::read_task(&task)?,
        period: period.parse().map_err(of_building)?,
        seed,
        steps_per_hour,
    })
}

/// A policy in Python.
struct InPython {
    name: String,
    identity: String,
    make: Py<PyAny>,
    rescale: bool,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Policy for InPython {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn controller(&self, context: EpisodeContext<'_>) -> b2b_benchmark::Result<Box<dyn Controller>> {
        let EpisodeContext { subject, surroundings, spaces, seed, .. } = context;
        let building = Arc::new(Inner::of_subject(subject, surroundings, spaces));
        let made = Python::attach(|py| {
            let seen = Spaces::new(Arc::clone(spaces), Arc::clone(&building));
            self.make.call1(py, (seen, Building { inner: building }, seed))
        });
        let act = made.map_err(|error| {
            fail(&self.raised, error);
            b2b_benchmark::Error::Interrupted
        })?;
        let (space, raised) = (spaces.action.clone(), Arc::clone(&self.raised));
        Ok(Box::new(Acting { act, space, rescale: self.rescale, raised }))
    }
}

/// A policy in Python in an episode.
struct Acting {
    act: Py<PyAny>,
    space: ActionSpace,
    rescale: bool,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Acting {
    fn ask(&self, observation: &[f64], action: &mut [f64]) -> PyResult<()> {
        Python::attach(|py| {
            let given = self.act.call1(py, (arrays::row(py, observation),))?;
            let given = arrays::numbers(given.bind(py))?;
            self.space.check(&given).map_err(crate::error::of_env)?;
            action.copy_from_slice(&given);
            if self.rescale {
                self.space.rescale(action);
            }
            Ok(())
        })
    }
}

impl Controller for Acting {
    /// There is one for each episode.
    fn reset(&mut self) {}

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        if let Err(error) = self.ask(observation, action) {
            // The environment refuses it, and the evaluation ends with the exception.
            action.fill(f64::NAN);
            fail(&self.raised, error);
        }
    }
}

/// Keeps the first exception, and ends the evaluation.
fn fail(raised: &Mutex<Option<PyErr>>, error: PyErr) {
    locked(raised).get_or_insert(error);
    STOP.store(true, Ordering::Relaxed);
}

/// How far it is, in simulated days.
#[derive(Default)]
struct Counter {
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
    /// Tells somebody in Python; whether that raised nothing.
    fn tell(&self, progress: Option<&Py<PyAny>>) -> bool {
        let Some(progress) = progress else { return true };
        let what = locked(&self.what).clone();
        let (done, all) = (self.done.load(Ordering::Relaxed), self.all.load(Ordering::Relaxed));
        Python::attach(|py| progress.call1(py, (what, done, all)).is_ok())
    }
}

/// The columns of a table as lists, by name.
fn columns<'py>(py: Python<'py>, table: &RecordBatch) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for (field, column) in table.schema().fields().iter().zip(table.columns()) {
        let values = if let Some(texts) = column.as_string_opt::<i32>() {
            PyList::new(py, texts)?
        } else if let Some(numbers) = column.as_primitive_opt::<Float64Type>() {
            PyList::new(py, numbers)?
        } else if let Some(numbers) = column.as_primitive_opt::<UInt64Type>() {
            PyList::new(py, numbers)?
        } else {
            PyList::new(py, column.as_primitive::<UInt32Type>())?
        };
        columns.set_item(field.name(), values)?;
    }
    Ok(columns)
}
