//! A batch of environments.

pub(crate) mod population;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use b2b_benchmark::problem::TrainingForm;
use b2b_env::{ActionSpace, InfoNumbers, to_info_numbers};
use b2b_workers::{Arrangement, Autoreset, Form, Padded, RowSlot, VecEnv as Envs, VecEnvOptions};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use self::population::{Candidate, Episodes, WeatherAndDays};
use crate::buildings::catalog::{self, Inner, read_control};
use crate::control;
use crate::evaluation::benchmarks::Problem;
use crate::interpreter::arrays;
use crate::interpreter::error::{Exception, of_env, of_evaluation};
use crate::interpreter::process::{OwnerProcess, locked};
use crate::spaces::Spaces;

/// A batch of environments, each in its own process.
#[pyclass(frozen, module = "building2building._core")]
pub struct VecEnv {
    owner: OwnerProcess,
    state: Mutex<BatchState>,
    /// Spaces of the environments, or of representatives of the buildings to draw from.
    spaces: Vec<(Arc<b2b_env::Spaces>, Arc<Inner>)>,
    /// For each of these, the slots of a row of observations.
    slots: Vec<Vec<RowSlot>>,
    /// For each of these, the action space of a row of actions.
    actions: Vec<ActionSpace>,
}

struct BatchState {
    /// `None` once closed.
    envs: Option<Envs>,
    rescale: bool,
}

/// Observations, rewards, numbers (see [`InfoNumbers`]) and truncations of the batch.
type SteppedBatch<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<bool>>,
);

/// The data of [`SteppedBatch`].
struct Batch {
    observations: Vec<f32>,
    rewards: Vec<f64>,
    numbers: Vec<f64>,
    truncated: Vec<bool>,
    shape: [usize; 2],
}

/// For each environment, which numbers of its row of observations and of its row of actions are not padding.
type Masks = (Vec<Vec<bool>>, Vec<Vec<bool>>);

/// Maximum number of buildings per environment for which templates stay in memory. With more, none stay, and each drawn
/// building is prepared again.
const KEPT_BUILDINGS: usize = 2;

/// Maximum number of environments in a batch, because a set of workers has at most that many processes.
const MAX_ENVIRONMENTS: usize = 2048;

/// An episode: building, weather file, and first day as day of a year without 29 February, from 1.
type Begun = (String, String, u32);
/// The end of an episode: last observation, metrics, and the reason if it was lost.
type Ended<'py> = (Bound<'py, PyArray1<f64>>, Option<Bound<'py, PyAny>>, Option<String>);

#[pymethods]
impl VecEnv {
    /// Prepares the buildings. With `resample`, environments draw a building every `resample` episodes, by the weights
    /// of the types; otherwise, environment i repeats pair i of a building and a task. `window` is the length of an
    /// episode in days and the number of possible first days. `problem` defines the form of observations and actions;
    /// `by_role` arranges observations of houses by the roles of their zones. With `weather_years`, every episode draws
    /// one of these weather files. `control` is what an agent sets in buildings that are generated when drawn.
    #[new]
    #[pyo3(signature = (
        buildings, tasks, run_period, timesteps_per_hour, count, autoreset, rescale, resample=None, weights=None,
        window=None, problem=None, by_role=false, weather_years=Vec::new(), control=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "the Python class passes them by name")]
    fn new(
        py: Python<'_>,
        buildings: Vec<Candidate<'_>>,
        tasks: Vec<String>,
        run_period: &str,
        timesteps_per_hour: u32,
        count: usize,
        autoreset: &str,
        rescale: bool,
        resample: Option<u32>,
        weights: Option<BTreeMap<String, f64>>,
        window: Option<(u32, u32)>,
        problem: Option<&Problem>,
        by_role: bool,
        weather_years: Vec<PathBuf>,
        control: Option<&str>,
    ) -> PyResult<Self> {
        check_count(count)?;
        let drawn = WeatherAndDays { weather_years, window };
        let autoreset = read_autoreset(autoreset)?;
        let many = buildings.len() > KEPT_BUILDINGS * count;
        let generated = buildings.iter().any(|each| matches!(each, Candidate::Generator(_)));
        let mut workers = catalog::worker_options(py)?;
        workers.template_memory = if resample.is_some() && (many || generated) { 0 } else { 2 << 30 };
        let control = read_control(control)?;
        let episodes = Episodes::new(&buildings, &tasks, run_period, timesteps_per_hour, control)?;
        let options = VecEnvOptions { workers, autoreset, widths: None };
        let problem = problem.map(|problem| &problem.inner);
        py.detach(|| {
            let made = match resample {
                Some(episodes_each) => {
                    let sampler = episodes.sampler(episodes_each, weights.as_ref(), drawn)?;
                    let envs = Envs::new(count, sampler, options).map_err(of_env)?;
                    let spaces = spaces_of_representatives(&envs, &episodes)?;
                    (envs, spaces)
                }
                None => {
                    let (settings, buildings): (Vec<_>, Vec<_>) =
                        episodes.repeated(count)?.into_iter().unzip();
                    let mut envs =
                        Envs::new(count, drawn.of_fixed(settings.clone()), options).map_err(of_env)?;
                    let spaces = envs.prepare(&settings).map_err(of_env)?;
                    (envs, spaces.into_iter().zip(buildings).collect())
                }
            };
            let arrangement = if by_role { Arrangement::ByRole } else { Arrangement::InOrder };
            Self::with_form(made.0, made.1, problem, arrangement, rescale)
        })
    }

    /// Returns the spaces of each building and task; with `resample`, of representative buildings.
    fn spaces(&self) -> Vec<Spaces> {
        let spaces = self.spaces.iter();
        spaces.map(|(spaces, building)| Spaces::new(Arc::clone(spaces), Arc::clone(building))).collect()
    }

    /// Returns names and bounds of the numbers in a row of observations, for each of [`VecEnv::spaces`].
    fn slots(&self) -> Vec<Vec<(String, f64, f64)>> {
        let slot = |slot: &RowSlot| (slot.name.clone(), slot.low, slot.high);
        self.slots.iter().map(|slots| slots.iter().map(slot).collect()).collect()
    }

    /// Returns names and bounds of the numbers in a row of actions, in physical units, for each of [`VecEnv::spaces`].
    fn actuators(&self) -> Vec<Vec<(String, f64, f64)>> {
        let of = |space: &ActionSpace| {
            let bounds = space.low().iter().zip(space.high());
            space.names().iter().zip(bounds).map(|(name, (low, high))| (name.clone(), *low, *high)).collect()
        };
        self.actions.iter().map(of).collect()
    }

    /// Returns the units of the numbers in a row of observations and of actions, for the first of [`VecEnv::spaces`].
    fn units(&self) -> (Vec<&'static str>, Vec<&'static str>) {
        let observed = self.slots.iter().take(1).flatten().map(|slot| slot.unit).collect();
        let quantities = self.actions.iter().take(1).flat_map(ActionSpace::quantities);
        (observed, quantities.map(|quantity| quantity.unit()).collect())
    }

    /// Returns the spaces of the building that an environment simulates.
    fn spaces_of(&self, py: Python<'_>, environment: usize) -> PyResult<Spaces> {
        let spaces = self.owner.with(py, &self.state, |state| {
            let spaces = state.envs()?.shared_spaces(environment).map(Arc::clone);
            spaces.ok_or_else(|| Exception::Episode.new_err("no episode has begun; call reset first"))
        })?;
        let same =
            |known: &&(Arc<b2b_env::Spaces>, Arc<Inner>)| known.0.building.name == spaces.building.name;
        Ok(match self.spaces.iter().find(same) {
            Some((_, building)) => Spaces::new(spaces, Arc::clone(building)),
            None => Spaces::drawn(spaces),
        })
    }

    /// Returns, for each environment, which numbers of its rows of observations and of actions are not padding.
    fn masks(&self, py: Python<'_>) -> PyResult<Masks> {
        self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            let (actions, observations) = envs.widths();
            let forms = (0..envs.len()).map(|environment| envs.form(environment));
            let masks = forms.map(|form| match form {
                None => (vec![false; observations], vec![false; actions]),
                Some(form) => {
                    let slots = form.slots().iter().map(|slot| *slot != RowSlot::padding()).collect();
                    (slots, (0..actions).map(|number| number < form.actions().len()).collect())
                }
            });
            Ok(masks.unzip())
        })
    }

    /// Returns the numbers of episodes, of building changes and of waits for a building, and the total waiting time, s.
    fn statistics(&self, py: Python<'_>) -> PyResult<(u64, u64, u64, f64)> {
        self.owner.with(py, &self.state, |state| {
            let statistics = state.envs()?.statistics();
            let waited = statistics.waited.as_secs_f64();
            Ok((statistics.episodes, statistics.building_changes, statistics.waits, waited))
        })
    }

    /// Returns the ids of all worker processes.
    fn processes(&self, py: Python<'_>) -> PyResult<Vec<u32>> {
        self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            let episodes = (0..envs.len()).filter_map(|environment| envs.process(environment));
            Ok(episodes.chain(envs.workers().template_processes()).collect())
        })
    }

    /// Starts an episode in every environment and returns the first observations.
    fn reset<'py>(&self, py: Python<'py>, seed: u64) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let batch = self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            envs.reset(seed).map_err(of_env)?;
            Ok(Batch::of(envs))
        })?;
        arrays::table(py, batch.observations, batch.shape)
    }

    /// Starts an episode in the given environments and returns the observations of all.
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
    fn step<'py>(&self, py: Python<'py>, actions: &Bound<'py, PyAny>) -> PyResult<SteppedBatch<'py>> {
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
                    if let Some(form) = envs.form(index) {
                        form.actions().rescale(action);
                    }
                }
            }
            envs.step(&actions).map_err(of_env)?;
            Ok(Batch::of(envs))
        })?;
        Ok((
            arrays::table(py, batch.observations, batch.shape)?,
            arrays::row(py, &batch.rewards),
            arrays::table(py, batch.numbers, [batch.shape[0], InfoNumbers::default().len()])?,
            arrays::row(py, &batch.truncated),
        ))
    }

    /// Repeats actions in physical units for `steps` steps without returning to Python, to measure the cost of a step
    /// in Rust alone.
    fn hold(&self, py: Python<'_>, actions: &Bound<'_, PyAny>, steps: usize) -> PyResult<()> {
        let (actions, _) = arrays::rows(actions)?;
        self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            (0..steps).try_for_each(|_| envs.step(&actions).map(|_| ()).map_err(of_env))
        })
    }

    /// Returns the final observation and metrics of an environment's last episode, and the reason if it was lost.
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

    /// Returns the name of the building, the weather file and the first day of each environment's episode.
    fn episodes(&self, py: Python<'_>) -> PyResult<Vec<Begun>> {
        self.owner.with(py, &self.state, |state| {
            let envs = state.envs()?;
            let of = |index| {
                let b2b_env::Spaces { building, episode, .. } = envs.spaces(index)?;
                let weather = episode.weather.display().to_string();
                Some((building.name.clone(), weather, episode.period.first().day_of_year()))
            };
            Ok((0..envs.len()).filter_map(of).collect())
        })
    }

    /// Width of a row of actions and of a row of observations, padding included.
    #[getter]
    fn widths(&self, py: Python<'_>) -> PyResult<(usize, usize)> {
        self.owner.with(py, &self.state, |state| Ok(state.envs()?.widths()))
    }

    /// Ends all processes.
    fn close(&self, py: Python<'_>) {
        if self.owner.is_current() {
            py.detach(|| locked(&self.state).envs = None);
        }
    }
}

impl VecEnv {
    /// Gives the environments the form of a problem, or pads them to the largest of the buildings.
    fn with_form(
        envs: Envs,
        spaces: Vec<(Arc<b2b_env::Spaces>, Arc<Inner>)>,
        problem: Option<&b2b_benchmark::Problem>,
        arrangement: Arrangement,
        rescale: bool,
    ) -> PyResult<Self> {
        let all: Vec<_> = spaces.iter().map(|(spaces, _)| Arc::clone(spaces)).collect();
        let mut form: Box<dyn Form> = match problem {
            Some(problem) => Box::new(TrainingForm::new(problem, &all, arrangement).map_err(of_evaluation)?),
            None => Box::new(Padded::fitting(&all, arrangement)),
        };
        let episodes = all.iter().map(|spaces| form.episode(spaces).map_err(of_env));
        let episodes = episodes.collect::<PyResult<Vec<_>>>()?;
        let slots = episodes.iter().map(|episode| episode.slots()).collect();
        let actions = episodes.iter().map(|episode| episode.actions().clone()).collect();
        let state = Mutex::new(BatchState { envs: Some(envs.with_form(form)), rescale });
        Ok(Self { owner: OwnerProcess::this(), state, spaces, slots, actions })
    }
}

impl BatchState {
    fn envs(&mut self) -> PyResult<&mut Envs> {
        let closed = || Exception::Episode.new_err("the environments are closed");
        self.envs.as_mut().ok_or_else(closed)
    }
}

impl Batch {
    fn of(envs: &Envs) -> Self {
        let steps = envs.rewards().iter().zip(envs.terms());
        Self {
            observations: envs.observations().iter().map(|value| *value as f32).collect(),
            rewards: envs.rewards().iter().map(|reward| reward.total()).collect(),
            numbers: steps.flat_map(|(reward, terms)| to_info_numbers(*reward, terms)).collect(),
            truncated: envs.truncated().to_vec(),
            shape: [envs.len(), envs.widths().1],
        }
    }
}

/// Returns the spaces of representatives of the buildings to draw from, under every task.
fn spaces_of_representatives(
    envs: &Envs,
    episodes: &Episodes,
) -> PyResult<Vec<(Arc<b2b_env::Spaces>, Arc<Inner>)>> {
    let mut spaces = Vec::new();
    for found in envs.workers().spaces(&episodes.representatives()?).map_err(of_env)? {
        let building = Arc::new(Inner::of_spaces(&found));
        let all = episodes.under_every_task(&found).into_iter();
        spaces.extend(all.map(|spaces| (spaces, Arc::clone(&building))));
    }
    Ok(spaces)
}

fn check_count(count: usize) -> PyResult<()> {
    if count <= MAX_ENVIRONMENTS {
        return Ok(());
    }
    let message = format!("num_envs is {count}; expected 1 to {MAX_ENVIRONMENTS}");
    Err(Exception::Setting.new_err(message))
}

fn read_autoreset(mode: &str) -> PyResult<Autoreset> {
    match mode {
        "NextStep" => Ok(Autoreset::NextStep),
        "SameStep" => Ok(Autoreset::SameStep),
        "Disabled" => Ok(Autoreset::Disabled),
        _ => Err(Exception::Setting.new_err(format!("unknown autoreset mode `{mode}`"))),
    }
}
