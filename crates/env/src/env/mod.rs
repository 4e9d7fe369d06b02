//! The in-process environment: reset and step.

mod engine;
mod engine_output;
mod meters;
mod observe;
mod readings;
mod setpoints_apart;
mod snapshot;
mod warm_up;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_base::scratch::temporary_folder;
use b2b_building::{HvacMeter, Model, PreparedBuilding};
use b2b_energyplus::{Event, Library, Messages, exclusive};
use tempfile::TempDir;

use self::engine::Engine;
use self::setpoints_apart::SetpointsApart;
pub use self::snapshot::Snapshot;
use crate::billing::Billing;
use crate::environment::{Environment, Step};
use crate::faults::Impairment;
use crate::forecast::Forecast;
use crate::metrics::Metrics;
use crate::metrics::oscillation::Oscillation;
use crate::reward::{Reward, RewardFunction, ZoneStep};
use crate::setpoints::band::Bands;
use crate::setpoints::calendar::Seasons;
use crate::setpoints::{Asked, Targets};
use crate::spaces::action::ActionSpace;
use crate::spaces::observation::ObservationSpace;
use crate::spaces::{EpisodeConfig, Spaces};
use crate::task::Task;
use crate::terms::Amounts;
use crate::zones::presence::{self, Attendance};
use crate::zones::ventilation::{Interlock, Ventilation};
use crate::zones::{ControlledZone, controlled_zones};
use crate::{Error, Result};

const MODEL_FILE: &str = "model.epJSON";

/// A building as an environment, with the engine in this process.
///
/// - Observation: [`ObservationSpace`], f64, the state at the end of the step.
/// - Action: [`ActionSpace`], f64, physical units, clamped to its bounds, raised by the interlock of [`Ventilation`]
///   while zones are occupied, and limited by the task's [`Faults`](crate::Faults). A cooling setpoint is at least 0.5
///   K above the heating setpoint of its zone.
/// - Reward: [`Reward`](crate::Reward), the paper's two penalties or the terms of the [`Task`], relative to the targets
///   observed before the step.
/// - End: truncated at the end of the run period; never terminated.
///
/// A step allocates nothing and starts no thread. Only one engine runs at a time in a process; for several
/// environments, or to survive a crash of the engine, see the crate `b2b-workers`.
#[derive(Debug)]
pub struct Env {
    library: Library,
    spaces: Arc<Spaces>,
    zones: Vec<ControlledZone>,
    targets: Targets,
    seasons: Seasons,
    reward: Box<dyn RewardFunction>,
    interlock: Interlock,
    setpoints_apart: SetpointsApart,
    impairment: Option<Impairment>,
    attendance: Option<Attendance>,
    billing: Billing,
    forecast: Option<Forecast>,
    /// Targets of each controlled zone for the next step.
    asked: Vec<Asked>,
    /// The controlled zones in the last step.
    zone_steps: Vec<ZoneStep>,
    engine: Option<Engine>,
    observation: Vec<f64>,
    action: Vec<f64>,
    metrics: Metrics,
    /// Terms of the last step.
    terms: Amounts,
    /// Oscillation of each controlled zone.
    oscillations: Vec<Oscillation>,
    truncated: bool,
    messages: Messages,
    never_occupied: Vec<String>,
    observe_effects: bool,
    /// The concatenated actions of the episode, if kept.
    history: Option<Vec<f64>>,
    /// Steps of an episode.
    steps: usize,
    /// Whether the engine finishes its run after the last step of the run period.
    finish_run: bool,
    /// The engine's meters of the energy that the task counts.
    meters: Vec<HvacMeter>,
    /// File to which the engine writes its meters.
    meter_file: PathBuf,
    /// The model file and the engine's own files.
    folder: PathBuf,
    /// The same folder, if temporary.
    _temporary: Option<TempDir>,
}

impl Env {
    /// Creates an environment. [`Env::reset`] starts its first episode.
    ///
    /// # Errors
    /// [`Error::StepsPerHour`]; the errors of [`Task::check`]; [`Error::Io`] when the model cannot be written to the
    /// temporary folder; errors of the building or the weather file.
    pub fn new(library: Library, building: Arc<PreparedBuilding>, episode: EpisodeConfig) -> Result<Self> {
        episode.check()?;
        building.check_period(episode.period).map_err(Error::building)?;
        let temporary = temporary_folder("b2b-env-").map_err(b2b_energyplus::Error::from)?;
        let folder = temporary.path().to_owned();
        let meters = meters::compared(&building, &episode.task);
        write_model(&folder, &episode_model(&building, &episode, &meters))?;
        let spaces = Spaces::new(building, episode);
        let task = &spaces.episode.task;
        let zones = controlled_zones(&spaces.building, task.heating_only_zones, task.is_operation())?;
        let seasons = Seasons::of(&spaces.episode.weather, spaces.episode.period.calendar())?;
        let reward = Task { energy_scale: Some(spaces.energy_scale()), ..task.clone() };
        let (model, steps_per_hour) = (spaces.building.model(), spaces.episode.steps_per_hour);
        let attendance = Attendance::new(task.presence, model, steps_per_hour)?;
        let (bands, class) = (Bands::of(&spaces), spaces.building.class);
        Ok(Self {
            library,
            observation: vec![0.0; spaces.observation.len()],
            action: vec![0.0; spaces.action.len()],
            metrics: new_metrics(&zones, &spaces),
            terms: Amounts::default(),
            oscillations: vec![Oscillation::default(); zones.len()],
            targets: Targets::new(&task.setpoints, bands, class, zones.len(), seasons),
            seasons,
            reward: Box::new(reward),
            interlock: Interlock::new(&spaces.building),
            setpoints_apart: SetpointsApart::new(&spaces.building),
            impairment: Impairment::new(&task.faults, &spaces.building),
            attendance,
            billing: Billing::new(&spaces.episode, spaces.building.conditioned_floor_area)?,
            forecast: forecast(&spaces.episode)?,
            asked: vec![Asked::UNKNOWN; zones.len()],
            zone_steps: Vec::with_capacity(zones.len()),
            engine: None,
            truncated: false,
            messages: Messages::default(),
            never_occupied: presence::never_occupied(&spaces.building, &zones)?,
            observe_effects: false,
            history: None,
            steps: spaces.episode_steps(),
            finish_run: true,
            meters,
            meter_file: folder.join(meters::METER_FILE),
            spaces: Arc::new(spaces),
            zones,
            folder,
            _temporary: Some(temporary),
        })
    }

    /// Makes the quantity driven by each actuator readable: see [`Env::effect`].
    #[must_use]
    pub fn observe_effects(mut self) -> Self {
        self.observe_effects = true;
        self
    }

    /// Replaces the task's reward.
    #[must_use]
    pub fn with_reward(mut self, reward: impl RewardFunction + 'static) -> Self {
        self.reward = Box::new(reward);
        self
    }

    /// Starts an episode: starts the engine and warms it up under a small fixed controller. Returns the observation at
    /// midnight of the first day, with zero energy.
    ///
    /// # Errors
    /// [`Error::Engine`] with the engine's messages; [`Error::ObservationNotFinite`].
    pub fn reset(&mut self) -> Result<&[f64]> {
        // Other threads may start and end episodes.
        let _exclusive = exclusive();
        self.engine = None;
        self.messages = Messages::default();
        self.truncated = false;
        self.metrics = new_metrics(&self.zones, &self.spaces);
        self.oscillations.fill(Oscillation::default());
        self.reward.reset();
        self.billing.restart();
        if let Some(history) = &mut self.history {
            history.clear();
        }
        let (model, spaces) = (self.folder.join(MODEL_FILE), &self.spaces);
        let (library, effects) = (&self.library, self.observe_effects);
        let attendance = self.attendance.as_ref();
        let mut engine = Engine::start(library, spaces, &self.zones, &model, attendance, effects)?;
        self.warm_up(&mut engine)?;
        if let Some(attendance) = &mut self.attendance {
            attendance.restart(self.spaces.episode.period.day_of_year(0));
        }
        self.observe(&engine, [0.0; 2])?;
        self.terms = Amounts::default();
        self.begin_kpis();
        self.disturb();
        self.engine = Some(engine);
        Ok(&self.observation)
    }

    /// Applies an action for one zone time step.
    ///
    /// # Errors
    /// [`Error::ActionNotFinite`] and [`Error::ActionLength`] leave the episode unchanged; [`Error::NotReset`]; all
    /// others, such as [`Error::Engine`], end it.
    pub fn step(&mut self, action: &[f64]) -> Result<Step<'_>> {
        let mut engine = self.engine.take().ok_or(Error::NotReset)?;
        match self.spaces.action.clamp_into(action, &mut self.action) {
            Ok(outside) => self.metrics.clamped_actions += outside,
            Err(error) => {
                self.engine = Some(engine);
                return Err(error);
            }
        }
        if let Some(history) = &mut self.history {
            history.extend_from_slice(action);
        }
        let reward = match self.advance(&mut engine) {
            Ok(reward) => reward,
            Err(error) => {
                self.messages = engine.simulation.messages();
                return Err(error);
            }
        };
        let truncated = self.metrics.steps == self.steps;
        if truncated && self.finish_run && self.steps == self.spaces.episode_steps() {
            self.finish(engine)?;
        } else {
            self.engine = Some(engine);
        }
        self.truncated = truncated;
        let terms = self.terms;
        Ok(Step { observation: &self.observation, action: &self.action, reward, terms, truncated })
    }

    /// Advances the engine by a step under the action, and returns the reward of the step.
    fn advance(&mut self, engine: &mut Engine) -> Result<Reward> {
        self.metrics.ventilation_overrides += usize::from(self.ventilate(engine));
        let impairment = self.impairment.as_ref();
        if let Some(impairment) = impairment {
            impairment.limit(&mut self.action);
        }
        let is_stuck = |index: usize| impairment.is_some_and(|faults| faults.is_stuck(index));
        self.setpoints_apart.apply(&mut self.action, is_stuck);
        match &mut self.impairment {
            Some(impairment) => engine.act(impairment.given(self.metrics.steps, &self.action)),
            None => engine.act(&self.action),
        }
        if let Some(attendance) = &mut self.attendance {
            engine.admit(attendance);
        }
        if engine.simulation.advance()? != Some(Event::Step) {
            return Err(self.wrong_length());
        }
        let floor_area = self.spaces.building.conditioned_floor_area;
        let is_operation = self.spaces.episode.task.is_operation();
        let (end_uses, of_end_uses) = engine.end_uses(floor_area);
        let by_carrier = if is_operation { of_end_uses } else { engine.energy(floor_area) };
        let energy = meters::electricity_and_fuels(&by_carrier);
        let began = self.moment();
        self.terms = self.measure(&end_uses, &by_carrier, began);
        self.metrics.add_outdoor_air(engine.outdoor_air());
        self.keep_targets();
        self.metrics.steps += 1;
        self.observe(engine, energy)?;
        let reward = self.judge(began, &by_carrier);
        self.disturb();
        Ok(reward)
    }

    /// The building with its observation and action spaces.
    pub fn spaces(&self) -> &Arc<Spaces> {
        &self.spaces
    }

    /// Names, units and bounds of the actuators.
    pub fn action_space(&self) -> &ActionSpace {
        &self.spaces.action
    }

    /// Names, units and bounds of the observation.
    pub fn observation_space(&self) -> &ObservationSpace {
        &self.spaces.observation
    }

    /// The building.
    pub fn building(&self) -> &PreparedBuilding {
        &self.spaces.building
    }

    /// The state at the end of the last step, or at the start of the episode.
    pub fn observation(&self) -> &[f64] {
        &self.observation
    }

    /// Weather, period, time step and task.
    pub fn episode(&self) -> &EpisodeConfig {
        &self.spaces.episode
    }

    /// The scale τ_E of the task's reward for this building: see [`Task::scale_for`].
    pub fn energy_scale(&self) -> f64 {
        self.spaces.energy_scale()
    }

    /// Steps of a whole episode.
    pub fn episode_steps(&self) -> usize {
        self.spaces.episode_steps()
    }

    /// Returns whether the episode is over.
    pub fn is_truncated(&self) -> bool {
        self.truncated
    }

    /// Applies the ventilation interlock to the action. Returns whether it changed.
    fn ventilate(&mut self, engine: &mut Engine) -> bool {
        if self.spaces.episode.task.ventilation == Ventilation::Free {
            return false;
        }
        engine.open_dampers();
        self.interlock.apply(|zone| engine.occupied(zone), &mut self.action)
    }

    /// Ends the engine's run, after checking that its run period is over.
    fn finish(&mut self, mut engine: Engine) -> Result<()> {
        let end = engine.simulation.advance();
        self.messages = engine.simulation.messages();
        if end?.is_some() {
            return Err(self.wrong_length());
        }
        Ok(())
    }

    fn wrong_length(&self) -> Error {
        Error::EpisodeLength { done: self.metrics.steps, expected: self.episode_steps() }
    }
}

impl Environment for Env {
    fn spaces(&self) -> &Arc<Spaces> {
        self.spaces()
    }

    fn reset(&mut self) -> Result<&[f64]> {
        self.reset()
    }

    fn step(&mut self, action: &[f64]) -> Result<Step<'_>> {
        self.step(action)
    }

    fn metrics(&self) -> Option<&Metrics> {
        self.is_truncated().then(|| self.metrics())
    }
}

/// For processes that end with their episode.
impl Env {
    /// Copies this process at the current point of the episode: see
    /// [`Simulation::fork`](b2b_energyplus::Simulation::fork). The copy's engine writes its meters to its own file, if
    /// given, and nothing else.
    pub fn fork(&mut self, meter_file: Option<&Path>) -> Result<b2b_energyplus::snapshot::Fork> {
        use b2b_energyplus::snapshot::{Fork, KeptFile};
        let engine = self.engine.as_mut().ok_or(Error::NotReset)?;
        // A copy writes to its own file, which its copies keep.
        let name = self.meter_file.file_name().unwrap_or_default().to_string_lossy();
        let kept = meter_file.map(|copy| KeptFile { name: &name, copy });
        let fork = engine.simulation.fork(kept)?;
        if let (Fork::Copy(_), Some(path)) = (&fork, meter_file) {
            self.meter_file = path.to_owned();
        }
        Ok(fork)
    }

    /// Truncates the episode after `steps` steps, or at the end of the run period.
    pub fn truncate_after(&mut self, steps: usize) {
        self.steps = steps.min(self.episode_steps());
    }

    /// Sets whether the engine finishes its run after the last step, or stays suspended.
    pub fn set_finish_run(&mut self, finish_run: bool) {
        self.finish_run = finish_run;
    }

    /// Drops the model, needed only by new environments, unless it is shared.
    pub fn drop_model(&mut self) {
        let spaces = Arc::get_mut(&mut self.spaces);
        if let Some(building) = spaces.and_then(|spaces| Arc::get_mut(&mut spaces.building)) {
            building.drop_model();
        }
    }

    /// The folder of the model and of the engine's own files.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

/// Returns the forecast of an episode, if its task has a preview.
fn forecast(episode: &EpisodeConfig) -> Result<Option<Forecast>> {
    let EpisodeConfig { weather, period, task, .. } = episode;
    task.preview.map(|preview| Forecast::new(preview, weather, period.calendar())).transpose()
}

/// Writes the model of an environment into its folder.
fn write_model(folder: &Path, model: &Model) -> Result<()> {
    let path = folder.join(MODEL_FILE);
    std::fs::write(&path, model.to_epjson()).map_err(|source| Error::Io { path, source })
}

/// The model of an episode, with the meters that the engine writes.
fn episode_model(building: &PreparedBuilding, episode: &EpisodeConfig, meters: &[HvacMeter]) -> Model {
    let mut model = building.model_for(episode.period, episode.steps_per_hour);
    meters::request(&mut model, meters);
    if let Some(balance) = episode.task.carbon_dioxide {
        balance.turn_on(&mut model);
    }
    model
}

fn new_metrics(zones: &[ControlledZone], spaces: &Spaces) -> Metrics {
    let episode = &spaces.episode;
    Metrics::new(zones, spaces.action.len(), episode.steps_per_hour, episode.task.comfort_band)
}
