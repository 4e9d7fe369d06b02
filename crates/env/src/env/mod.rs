//! The in-process environment: reset and step.

mod engine;
mod engine_output;
mod meters;
mod observe;
mod setpoints_apart;
mod snapshot;
mod warm_up;

#[cfg(target_os = "linux")]
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

use b2b_base::scratch::temporary_folder;
use b2b_building::{HvacMeter, Model, PreparedBuilding};
use b2b_energyplus::{Clock, Event, Level, Library, Messages, exclusive};
use tempfile::TempDir;

use self::engine::Engine;
use self::setpoints_apart::SetpointsApart;
pub use self::snapshot::Snapshot;
use crate::billing::Billing;
use crate::engine_report::EngineReport;
use crate::environment::{Environment, Step};
use crate::faults::Impairment;
use crate::metrics::Metrics;
use crate::metrics::oscillation::Oscillation;
use crate::preview::Forecast;
use crate::reward::{Reward, RewardFunction, ZoneStep};
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
/// Severe messages in an [`EngineReport`].
const SEVERES_KEPT: usize = 5;

/// A building as an environment, with the engine in this process.
///
/// - Observation: [`ObservationSpace`], f64, the state at the end of the step.
/// - Action: [`ActionSpace`], f64, physical units, clamped to its bounds, raised by the interlock of [`Ventilation`] while
///   zones are occupied, and limited by the task's [`Faults`](crate::Faults). A cooling setpoint is at least 0.5 K above the
///   heating setpoint of its zone.
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
    /// [`Error::StepsPerHour`]; [`Error::TaskValue`]; [`Error::Io`] when the model cannot be written to the temporary folder.
    pub fn new(library: Library, building: Arc<PreparedBuilding>, episode: EpisodeConfig) -> Result<Self> {
        episode.check()?;
        building.check_period(episode.period).map_err(Error::building)?;
        let temporary = temporary_folder("b2b-env-").map_err(b2b_energyplus::Error::from)?;
        let folder = temporary.path().to_owned();
        let path = folder.join(MODEL_FILE);
        let meters = meters::compared(&building, &episode.task);
        std::fs::write(&path, episode_model(&building, &episode, &meters).to_epjson())
            .map_err(|source| Error::Io { path, source })?;
        let spaces = Spaces::new(building, episode);
        let task = &spaces.episode.task;
        let zones = controlled_zones(&spaces.building, task)?;
        let seasons = Seasons::of(&spaces.episode.weather, spaces.episode.period.calendar())?;
        let reward = Task { energy_scale: Some(spaces.energy_scale()), ..task.clone() };
        Ok(Self {
            library,
            observation: vec![0.0; spaces.observation.len()],
            action: vec![0.0; spaces.action.len()],
            metrics: new_metrics(&zones, &spaces),
            terms: Amounts::default(),
            oscillations: vec![Oscillation::default(); zones.len()],
            targets: Targets::of(&spaces, seasons),
            seasons,
            reward: Box::new(reward),
            interlock: Interlock::new(&spaces.building),
            setpoints_apart: SetpointsApart::new(&spaces.building),
            impairment: Impairment::new(&task.faults, &spaces.building),
            attendance: Attendance::new(
                task.presence,
                spaces.building.model(),
                spaces.episode.steps_per_hour,
            )?,
            billing: Billing::new(
                task,
                &spaces.episode.weather,
                spaces.episode.period,
                spaces.building.conditioned_floor_area,
                spaces.episode.steps_per_hour,
            )?,
            forecast: task
                .preview
                .map(|preview| {
                    Forecast::new(preview, &spaces.episode.weather, spaces.episode.period.calendar())
                })
                .transpose()?,
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
    /// [`Error::Engine`] with the engine's messages.
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
    /// [`Error::ActionNotFinite`] and [`Error::ActionLength`] leave the episode unchanged; [`Error::Engine`] ends it;
    /// [`Error::NotReset`].
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
        if let Some(impairment) = &self.impairment {
            impairment.limit(&mut self.action);
        }
        self.setpoints_apart.apply(&mut self.action);
        engine.act(&self.action);
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

    /// Metrics of the episode in progress, or of the last one.
    pub fn metrics(&self) -> &Metrics {
        &self.metrics
    }

    /// The task's comfort penalties of the last step, one for each controlled zone in model order. Their mean is the
    /// temperature penalty of the task's own reward.
    pub fn comfort_penalties(&self) -> impl Iterator<Item = f64> {
        let began = self.beginning_of(self.metrics.steps.saturating_sub(1));
        let season = self.seasons.on(began.day_of_year);
        let comfort = &self.spaces.episode.task.comfort;
        self.zone_steps.iter().map(move |zone| comfort.penalty(zone, season))
    }

    /// Number of engine messages of a level in this episode.
    pub fn message_count(&self, level: Level) -> usize {
        match &self.engine {
            Some(engine) => engine.simulation.message_count(level),
            None => self.messages.count(level),
        }
    }

    /// The engine's messages in this episode, even after a failed step.
    pub fn messages(&self) -> Messages {
        match &self.engine {
            Some(engine) => engine.simulation.messages(),
            None => self.messages.clone(),
        }
    }

    /// EnergyPlus's own HVAC meters over a finished episode, Wh/m²: electricity, and fuels with district energy.
    ///
    /// # Errors
    /// [`Error::Io`] before the end of the run period, when the engine writes them.
    pub fn engine_meters(&self) -> Result<[f64; 2]> {
        let building = &self.spaces.building;
        meters::read(&self.meter_file, &self.meters, building.conditioned_floor_area)
    }

    /// Messages, meters and occupancy of the engine's run, for a finished episode.
    pub fn engine_report(&self) -> EngineReport {
        let messages = self.messages();
        let warnings = messages.iter().filter(|message| message.level == Level::Warning);
        let severes = messages.at_least(Level::Severe).take(SEVERES_KEPT);
        EngineReport {
            warnings: messages.count(Level::Warning),
            severes: messages.count(Level::Severe),
            warning_messages: warnings.map(|message| message.text.clone()).collect(),
            severe_messages: severes.map(|message| message.text.clone()).collect(),
            meters: self.engine_meters().ok(),
            never_occupied: self.never_occupied.clone(),
            bill: self.billing.parts(),
        }
    }

    /// The simulated quantity driven by an actuator at the end of the last step, in the unit of its effect. `None`
    /// without [`Env::observe_effects`] or an episode in progress.
    pub fn effect(&self, actuator: usize) -> Option<f64> {
        let engine = self.engine.as_ref()?;
        engine.effects.get(actuator).map(|variable| engine.simulation.read(*variable))
    }

    /// The heat called for by a heating setpoint in the last step, W. `None` for other actuators and in the cases of
    /// [`Env::effect`].
    pub fn heat(&self, actuator: usize) -> Option<f64> {
        let engine = self.engine.as_ref()?;
        engine.heats.get(actuator).copied().flatten().map(|variable| engine.simulation.read(variable))
    }

    /// The outdoor air mass flow of each system at the end of the last step, kg/s, and the people in its zones; `None` for
    /// a system without outdoor air. Empty without an episode in progress.
    pub fn outdoor_air(&self) -> Vec<Option<[f64; 2]>> {
        let engine = self.engine.as_ref();
        engine.map(Engine::outdoor_air_by_system).unwrap_or_default()
    }

    /// The engine's own clock at the end of the last step; the time in the observation comes from the calendar. `None`
    /// without an episode in progress.
    pub fn engine_clock(&self) -> Option<Clock> {
        self.engine.as_ref().map(|engine| engine.simulation.clock())
    }

    /// The names of the controlled zones that are never occupied: with occupancy setpoints, their target is always the
    /// unoccupied one.
    pub fn never_occupied(&self) -> impl Iterator<Item = &str> {
        self.never_occupied.iter().map(String::as_str)
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
#[cfg(target_os = "linux")]
impl Env {
    /// Copies this process at the current point of the episode: see
    /// [`Simulation::fork`](b2b_energyplus::Simulation::fork). The copy's engine writes its meters to its own file, if
    /// given, and nothing else.
    pub fn fork(&mut self, meter_file: Option<&Path>) -> Result<b2b_energyplus::snapshot::Fork> {
        use b2b_energyplus::snapshot::{Fork, KeptFile};
        let engine = self.engine.as_mut().ok_or(Error::NotReset)?;
        let kept = meter_file.map(|copy| KeptFile { name: meters::METER_FILE, copy });
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
