//! The environment: reset and step.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_building::hvac::EngineVariable;
use b2b_building::{PreparedBuilding, RunPeriod};
use b2b_energyplus::{Actuator, Clock, Event, Level, Library, Messages, Meter, Run, Simulation, Variable};
use serde::{Deserialize, Serialize};
use tempfile::TempDir;

use crate::action::ActionSpace;
use crate::calendar::Moment;
use crate::metrics::Metrics;
use crate::observation::{ObservationSpace, Shared, Target};
use crate::reward::{Reward, RewardFunction, StepView, ZoneStep};
use crate::setpoints::Targets;
use crate::task::Task;
use crate::warmup;
use crate::zones::{ControlledZone, controlled_zones};
use crate::{Error, Result};

/// What the engine takes.
const STEPS_PER_HOUR: [u32; 12] = [1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60];
/// The meters that make HVAC energy; a building need not have both.
const METERS: [&str; 2] = ["Electricity:HVAC", "NaturalGas:HVAC"];
const JOULES_PER_WATT_HOUR: f64 = 3600.0;

/// What an episode is made of, beside the building.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// Weather file (EPW).
    pub weather: PathBuf,
    /// Days it covers.
    pub period: RunPeriod,
    /// Zone time steps an hour, each one step of the environment.
    pub steps_per_hour: u32,
    /// What is asked.
    pub task: Task,
}

/// A building as an environment.
///
/// - Observation: [`ObservationSpace`], f64, the state at the end of the step.
/// - Action: [`ActionSpace`], f64, physical units, clamped to its bounds.
/// - Reward: [`Reward`], the paper's two penalties or what else the [`Task`] says, by the targets that were observed
///   before the step.
/// - End: truncated at the end of the run period; never terminated.
///
/// A step allocates nothing and starts no thread.
#[derive(Debug)]
pub struct Env {
    library: Library,
    building: Arc<PreparedBuilding>,
    episode: Episode,
    action_space: ActionSpace,
    observation_space: ObservationSpace,
    zones: Vec<ControlledZone>,
    targets: Targets,
    reward: Box<dyn RewardFunction>,
    /// Of each controlled zone, whether it is occupied, and its target for the step to come, °C.
    asked: Vec<(bool, f64)>,
    /// The controlled zones in the last step.
    zone_steps: Vec<ZoneStep>,
    live: Option<Live>,
    observation: Vec<f64>,
    action: Vec<f64>,
    metrics: Metrics,
    messages: Messages,
    observe_effects: bool,
    /// The actions of the episode, one after another, if they are kept.
    history: Option<Vec<f64>>,
    /// Steps after which an episode is left where it stands, the engine with it.
    left_after: Option<usize>,
    /// The model file and the engine's own files; goes with the environment.
    folder: TempDir,
}

/// What a step gives.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// State at the end of the step.
    pub observation: &'a [f64],
    /// The action as carried out.
    pub action: &'a [f64],
    /// Reward by its terms.
    pub reward: Reward,
    /// Whether the run period is over.
    pub truncated: bool,
}

/// Where an episode stood: what it is of, and every action up to there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    building: String,
    episode: Episode,
    /// As they were given, one after another.
    actions: Vec<f64>,
}

/// A simulation in progress with its handles.
#[derive(Debug)]
struct Live {
    simulation: Simulation,
    temperatures: Vec<Variable>,
    outdoor: [Variable; 2],
    /// People in each controlled zone; `None` where the model never has any.
    people: Vec<Option<Variable>>,
    meters: [Option<Meter>; 2],
    actuators: Vec<(Actuator, f64)>,
    /// What the actuators drive, if it is observed.
    effects: Vec<Variable>,
    /// The heat that heating setpoints call for, if it is observed.
    heats: Vec<Option<Variable>>,
}

impl Env {
    /// An environment; [`Env::reset`] starts its first episode.
    ///
    /// # Errors
    /// [`Error::StepsPerHour`]; [`Error::TaskValue`]; [`Error::Io`] when the model cannot be written to the temporary folder.
    pub fn new(library: Library, building: Arc<PreparedBuilding>, episode: Episode) -> Result<Self> {
        if !STEPS_PER_HOUR.contains(&episode.steps_per_hour) {
            return Err(Error::StepsPerHour(episode.steps_per_hour));
        }
        episode.task.check()?;
        let folder = tempfile::Builder::new()
            .prefix("b2b-env-")
            .tempdir()
            .map_err(|source| Error::Io { path: std::env::temp_dir(), source })?;
        let mut model = building.model_for(episode.period, episode.steps_per_hour);
        report_meters(&mut model);
        let path = folder.path().join(MODEL_FILE);
        std::fs::write(&path, model.to_epjson()).map_err(|source| Error::Io { path, source })?;
        let action_space = ActionSpace::of(&building);
        let observation_space =
            ObservationSpace::of(&building, episode.steps_per_hour, &episode.task.setpoints);
        let zones = controlled_zones(&building, &episode.task);
        let scale = episode.task.scale_for(building.class, episode.steps_per_hour);
        let reward = Task { energy_scale: Some(scale), ..episode.task.clone() };
        Ok(Self {
            live: None,
            observation: vec![0.0; observation_space.len()],
            action: vec![0.0; action_space.len()],
            metrics: new_metrics(&zones, &action_space, &episode),
            messages: Messages::default(),
            targets: Targets::new(&episode.task.setpoints, building.class, zones.len()),
            reward: Box::new(reward),
            asked: vec![(false, f64::NAN); zones.len()],
            zone_steps: Vec::with_capacity(zones.len()),
            observe_effects: false,
            history: None,
            left_after: None,
            library,
            building,
            episode,
            action_space,
            observation_space,
            zones,
            folder,
        })
    }

    /// Has the engine keep what each actuator drives readable: see [`Env::effect`].
    #[must_use]
    pub fn observe_effects(mut self) -> Self {
        self.observe_effects = true;
        self
    }

    /// Keeps the actions of an episode, so that [`Env::snapshot`] can take it back to where it stood. A step then
    /// allocates now and then.
    #[must_use]
    pub fn keep_history(mut self) -> Self {
        self.history = Some(Vec::new());
        self
    }

    /// Judges by a reward of one's own in place of the task's.
    #[must_use]
    pub fn with_reward(mut self, reward: impl RewardFunction + 'static) -> Self {
        self.reward = Box::new(reward);
        self
    }

    /// Starts an episode: the engine is started and warmed up under a small fixed controller. Returns the
    /// observation at midnight of the first day, with no energy yet.
    ///
    /// # Errors
    /// [`Error::Engine`] with the engine's words.
    pub fn reset(&mut self) -> Result<&[f64]> {
        self.live = None;
        self.metrics = new_metrics(&self.zones, &self.action_space, &self.episode);
        self.reward.reset();
        if let Some(history) = &mut self.history {
            history.clear();
        }
        let effects = self.observe_effects;
        let (model, weather) = (self.model_path(), &self.episode.weather);
        let mut live = Live::start(&self.library, &self.building, &self.zones, &model, weather, effects)?;
        self.warm_up(&mut live)?;
        self.observe(&live, [0.0; 2])?;
        self.live = Some(live);
        Ok(&self.observation)
    }

    /// Carries out an action for one zone time step.
    ///
    /// # Errors
    /// [`Error::ActionNotFinite`] and [`Error::ActionLength`] leave the episode as it is;
    /// [`Error::Engine`] ends it; [`Error::NotReset`].
    pub fn step(&mut self, action: &[f64]) -> Result<Step<'_>> {
        let mut live = self.live.take().ok_or(Error::NotReset)?;
        match self.action_space.clamp_into(action, &mut self.action) {
            Ok(outside) => self.metrics.clamped_actions += outside,
            Err(error) => {
                self.live = Some(live);
                return Err(error);
            }
        }
        if let Some(history) = &mut self.history {
            history.extend_from_slice(action);
        }
        live.act(&self.action);
        if live.simulation.advance()? != Some(Event::Step) {
            return Err(self.wrong_length());
        }
        let energy = live.energy(self.building.conditioned_floor_area);
        let began = self.moment();
        self.keep_targets();
        self.metrics.steps += 1;
        self.observe(&live, energy)?;
        let reward = self.judge(energy, began);
        let truncated = self.metrics.steps == self.left_after.unwrap_or(self.episode_steps());
        if truncated && self.left_after.is_none() {
            self.finish(live)?;
        } else {
            self.live = Some(live);
        }
        Ok(Step { observation: &self.observation, action: &self.action, reward, truncated })
    }

    /// Where the episode stands, to come back to. `None` without [`Env::keep_history`] or an episode in progress.
    pub fn snapshot(&self) -> Option<Snapshot> {
        let actions = self.history.clone().filter(|_| self.live.is_some())?;
        Some(Snapshot { building: self.building.name.clone(), episode: self.episode.clone(), actions })
    }

    /// Comes back to where a snapshot was taken, bit for bit, by a fresh start and the same actions: for systems that
    /// cannot copy a process, and for processes of their own. Where the system can, a
    /// [`Pool`](crate::vector::Pool) does it in a millisecond.
    ///
    /// # Errors
    /// [`Error::OtherSnapshot`] when it was taken of another building or episode; those of [`Env::reset`].
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<&[f64]> {
        if snapshot.building != self.building.name || snapshot.episode != self.episode {
            let (taken, here) = (snapshot.building.clone(), self.building.name.clone());
            return Err(Error::OtherSnapshot { taken, here });
        }
        self.reset()?;
        for action in snapshot.actions.chunks_exact(self.action_space.len()) {
            self.step(action)?;
        }
        Ok(&self.observation)
    }

    /// What is driven, between which bounds.
    pub fn action_space(&self) -> &ActionSpace {
        &self.action_space
    }

    /// What is seen.
    pub fn observation_space(&self) -> &ObservationSpace {
        &self.observation_space
    }

    /// The building.
    pub fn building(&self) -> &PreparedBuilding {
        &self.building
    }

    /// The state at the end of the last step, or at the start of the episode.
    pub fn observation(&self) -> &[f64] {
        &self.observation
    }

    /// What the episode is made of.
    pub fn episode(&self) -> &Episode {
        &self.episode
    }

    /// The scale τ_E of the task's reward here: see [`Task::scale_for`].
    pub fn energy_scale(&self) -> f64 {
        self.episode.task.scale_for(self.building.class, self.episode.steps_per_hour)
    }

    /// Steps of a whole episode.
    pub fn episode_steps(&self) -> usize {
        (self.episode.period.days() * 24 * self.episode.steps_per_hour) as usize
    }

    /// Sums over the episode in progress, or the last one.
    pub fn metrics(&self) -> &Metrics {
        &self.metrics
    }

    /// How many messages of a level the engine has given in this episode.
    pub fn message_count(&self, level: Level) -> usize {
        match &self.live {
            Some(live) => live.simulation.message_count(level),
            None => self.messages.count(level),
        }
    }

    /// What the engine has said in this episode.
    pub fn messages(&self) -> Messages {
        match &self.live {
            Some(live) => live.simulation.messages(),
            None => self.messages.clone(),
        }
    }

    /// The engine's own meters over a finished episode, Wh/m²: electricity and gas.
    ///
    /// # Errors
    /// [`Error::Io`] when the engine has not written them, which it does at the end of the run period.
    pub fn engine_meters(&self) -> Result<[f64; 2]> {
        let path = self.folder.path().join("eplusout.mtr");
        let text = std::fs::read_to_string(&path).map_err(|source| Error::Io { path, source })?;
        let area = self.building.conditioned_floor_area;
        Ok(METERS.map(|meter| run_period_value(&text, meter).unwrap_or(0.0) / JOULES_PER_WATT_HOUR / area))
    }

    /// The quantity that an actuator drives, as the engine has it at the end of the last step, in the unit of
    /// its effect. `None` without [`Env::observe_effects`] or an episode in progress.
    pub fn effect(&self, actuator: usize) -> Option<f64> {
        let live = self.live.as_ref()?;
        live.effects.get(actuator).map(|variable| live.simulation.read(*variable))
    }

    /// The heat that a heating setpoint called for in the last step, W. `None` for other actuators, and as
    /// [`Env::effect`].
    pub fn heat(&self, actuator: usize) -> Option<f64> {
        let live = self.live.as_ref()?;
        live.heats.get(actuator).copied().flatten().map(|variable| live.simulation.read(variable))
    }

    /// The engine's own clock at the end of the last step; the observation's is the calendar's. `None` without
    /// an episode in progress.
    pub fn engine_clock(&self) -> Option<Clock> {
        self.live.as_ref().map(|live| live.simulation.clock())
    }

    /// Copies this process where the episode stands: see [`Simulation::fork`].
    #[cfg(target_os = "linux")]
    pub(crate) fn fork(&mut self) -> Result<b2b_energyplus::snapshot::Fork> {
        let live = self.live.as_mut().ok_or(Error::NotReset)?;
        Ok(live.simulation.fork()?)
    }

    /// Truncates the episode after so many steps, or at the end of the run period if 0, and lets the engine stand
    /// there: for a process that ends with its episode.
    #[cfg(target_os = "linux")]
    pub(crate) fn leave_after(&mut self, steps: usize) {
        let whole = self.episode_steps();
        self.left_after = Some(if steps == 0 { whole } else { steps.min(whole) });
    }

    /// Lets go of what only a fresh environment needs, if nobody else has it.
    #[cfg(target_os = "linux")]
    pub(crate) fn forget_model(&mut self) {
        if let Some(building) = Arc::get_mut(&mut self.building) {
            building.forget_model();
        }
    }

    /// The folder of the model and of the engine's own files.
    #[cfg(target_os = "linux")]
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The controlled zones in which nobody ever is, by name: under occupancy setpoints they are always let go. Empty
    /// without an episode in progress.
    pub fn never_occupied(&self) -> impl Iterator<Item = &str> {
        let people = self.live.iter().flat_map(|live| &live.people);
        let empty = self.zones.iter().zip(people).filter(|(_, people)| people.is_none());
        empty.map(|(zone, _)| self.building.zones[zone.slot].name.as_str())
    }

    /// When the next step begins: the time of the observation.
    fn moment(&self) -> Moment {
        let steps_per_day = 24 * self.episode.steps_per_hour as usize;
        let day = (self.metrics.steps / steps_per_day) as u32;
        Moment {
            day_of_year: (self.episode.period.first().day_of_year() - 1 + day) % 365 + 1,
            hour: (self.metrics.steps % steps_per_day) as f64 / f64::from(self.episode.steps_per_hour),
        }
    }

    /// Keeps by what the step in progress is judged: what was asked before it.
    fn keep_targets(&mut self) {
        self.zone_steps.clear();
        self.zone_steps.extend(self.zones.iter().enumerate().map(|(index, zone)| ZoneStep {
            temperature: f64::NAN,
            target: self.asked[index].1,
            occupied: self.asked[index].0,
            penalize_above_target: zone.penalize_above_target,
        }));
    }

    /// The reward of the step that has just been observed, and its metrics.
    fn judge(&mut self, energy: [f64; 2], began: Moment) -> Reward {
        for (step, zone) in self.zone_steps.iter_mut().zip(&self.zones) {
            step.temperature = self.observation[zone.slot];
        }
        let (cost, emissions) = self.episode.task.cost_and_emissions(energy, began.hour);
        let step = StepView {
            zones: &self.zone_steps,
            observation: &self.observation,
            action: &self.action,
            electricity: energy[0],
            gas: energy[1],
            cost,
            emissions,
            peak_rise: self.metrics.peak_rise(energy[0]),
            day_of_year: began.day_of_year,
            hour: began.hour,
        };
        let reward = self.reward.reward(&step);
        self.metrics.add(reward, &step, self.action_space.low(), self.action_space.high());
        reward
    }

    fn model_path(&self) -> PathBuf {
        self.folder.path().join(MODEL_FILE)
    }

    /// Nothing is set before the first step: the engine takes the first opening of a damper for a floor under
    /// all that follow.
    fn warm_up(&mut self, live: &mut Live) -> Result<()> {
        // Nothing is set before the first step: a terminal takes the value of its flow schedule at the start of
        // the run for its least flow, and the prepared model has 0 there.
        let systems = &self.building.systems;
        let first_day = self.moment().day_of_year;
        loop {
            match live.simulation.advance()? {
                Some(Event::WarmupStep) => {
                    // The first day, over and over.
                    let hour = live.simulation.clock().hour_of_day % 24.0;
                    let moment = Moment { day_of_year: first_day, hour };
                    self.zone_steps.clear();
                    for (index, zone) in self.zones.iter().enumerate() {
                        let (occupied, target) = self.targets.at(index, moment, live.occupied(index));
                        let temperature = live.simulation.read(live.temperatures[zone.slot]);
                        let penalize_above_target = zone.penalize_above_target;
                        self.zone_steps.push(ZoneStep {
                            temperature,
                            target,
                            occupied,
                            penalize_above_target,
                        });
                    }
                    let (zones, steps) = (&self.zones, &self.zone_steps);
                    let zone = |name: &str| {
                        // The zones of a system are controlled ones: preparation took them from there.
                        let named = |(zone, _): &(&ControlledZone, &ZoneStep)| {
                            self.building.zones[zone.slot].name.eq_ignore_ascii_case(name)
                        };
                        let step = zones.iter().zip(steps).find(named).map(|(_, step)| step);
                        step.map_or([21.0; 2], |step| [step.target, step.temperature])
                    };
                    warmup::action(systems, zone, &mut self.action);
                    live.act(&self.action);
                }
                Some(Event::WarmedUp) => return Ok(()),
                _ => return Err(self.wrong_length()),
            }
        }
    }

    /// Writes the observation. `energy` in Wh/m², electricity and gas.
    fn observe(&mut self, live: &Live, energy: [f64; 2]) -> Result<()> {
        for (slot, variable) in self.observation.iter_mut().zip(&live.temperatures) {
            *slot = live.simulation.read(*variable);
        }
        let space = &self.observation_space;
        let [temperature, humidity] = live.outdoor.map(|v| live.simulation.read(v));
        let moment = self.moment();
        let mut put = |slot: Shared, value: f64| self.observation[space.shared(slot)] = value;
        put(Shared::OutdoorTemperature, temperature);
        put(Shared::OutdoorHumidity, humidity);
        let steps_per_day = 24 * self.episode.steps_per_hour as usize;
        let day = (self.metrics.steps / steps_per_day) as u32;
        let first = self.episode.period.first();
        put(Shared::TimeOfDay, moment.hour);
        put(Shared::DayOfWeek, f64::from((first.weekday() + day) % 7));
        put(Shared::DayOfYear, f64::from(moment.day_of_year));
        put(Shared::Electricity, energy[0]);
        put(Shared::Gas, energy[1]);
        for zone in 0..self.zones.len() {
            let (occupied, target) = self.targets.at(zone, moment, live.occupied(zone));
            self.asked[zone] = (occupied, target);
            if let (Some(occupancy), Target::Slot(slot)) = (space.occupancy(zone), space.target(zone)) {
                self.observation[occupancy] = f64::from(u8::from(occupied));
                self.observation[slot] = target;
            }
        }
        match self.observation.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(slot) => Err(Error::ObservationNotFinite {
                slot: space.slots()[slot].name.clone(),
                value: self.observation[slot],
                step: self.metrics.steps,
            }),
        }
    }

    /// Lets the engine end its run: it must agree that the run period is over.
    fn finish(&mut self, mut live: Live) -> Result<()> {
        let end = live.simulation.advance()?;
        self.messages = live.simulation.messages();
        if end.is_some() {
            return Err(self.wrong_length());
        }
        Ok(())
    }

    fn wrong_length(&self) -> Error {
        Error::EpisodeLength { done: self.metrics.steps, expected: self.episode_steps() }
    }
}

fn new_metrics(zones: &[ControlledZone], actions: &ActionSpace, episode: &Episode) -> Metrics {
    Metrics::new(zones, actions.len(), episode.steps_per_hour, episode.task.comfort_band)
}

const MODEL_FILE: &str = "model.epJSON";

impl Live {
    fn start(
        library: &Library,
        building: &PreparedBuilding,
        zones: &[ControlledZone],
        model: &Path,
        weather: &Path,
        observe_effects: bool,
    ) -> Result<Self> {
        const TEMPERATURE: &str = "Zone Mean Air Temperature";
        const OUTDOOR: [&str; 2] =
            ["Site Outdoor Air Drybulb Temperature", "Site Outdoor Air Relative Humidity"];
        const SITE: &str = "Environment";
        const PEOPLE: &str = "Zone People Occupant Count";
        let folder = model.parent().unwrap_or(Path::new("."));
        let mut run = Run::new(model, weather).output(folder).yield_in_warmup();
        for zone in &building.zones {
            run = run.request(TEMPERATURE, &zone.name);
        }
        for name in OUTDOOR {
            run = run.request(name, SITE);
        }
        let controlled = || zones.iter().map(|zone| building.zones[zone.slot].name.as_str());
        for name in controlled() {
            run = run.request(PEOPLE, name);
        }
        let observed: Vec<_> = building.actuators().filter(|_| observe_effects).collect();
        for variable in observed.iter().flat_map(|a| [Some(&a.effect), a.heat.as_ref()]).flatten() {
            run = run.request(&variable.name, &variable.key);
        }
        let simulation = run.start(library)?;
        let actuator = |a: &b2b_building::hvac::Actuator| {
            Ok((simulation.actuator(&a.component, &a.control, &a.key)?, a.scale))
        };
        let variable = |v: &EngineVariable| Ok(simulation.variable(&v.name, &v.key)?);
        Ok(Self {
            temperatures: building
                .zones
                .iter()
                .map(|zone| simulation.variable(TEMPERATURE, &zone.name))
                .collect::<std::result::Result<_, _>>()?,
            outdoor: [simulation.variable(OUTDOOR[0], SITE)?, simulation.variable(OUTDOOR[1], SITE)?],
            // The engine has the variable for zones with people alone.
            people: controlled().map(|name| simulation.variable(PEOPLE, name).ok()).collect(),
            meters: METERS.map(|meter| simulation.meter(meter).ok()),
            actuators: building.actuators().map(actuator).collect::<Result<_>>()?,
            effects: observed.iter().map(|a| variable(&a.effect)).collect::<Result<_>>()?,
            heats: observed
                .iter()
                .map(|a| a.heat.as_ref().map(variable).transpose())
                .collect::<Result<_>>()?,
            simulation,
        })
    }

    fn act(&mut self, action: &[f64]) {
        for ((actuator, scale), value) in self.actuators.iter().zip(action) {
            self.simulation.set(*actuator, value * scale);
        }
    }

    /// Whether anyone is in a controlled zone.
    fn occupied(&self, controlled_zone: usize) -> bool {
        self.people[controlled_zone].is_some_and(|people| self.simulation.read(people) > 0.0)
    }

    /// HVAC energy of the step by fuel, Wh/m².
    fn energy(&self, floor_area: f64) -> [f64; 2] {
        self.meters.map(|meter| {
            meter.map_or(0.0, |m| self.simulation.read_meter(m)) / JOULES_PER_WATT_HOUR / floor_area
        })
    }
}

/// Has the engine write its own sum of the HVAC meters over the run period, to be compared with ours.
fn report_meters(model: &mut b2b_building::Model) {
    for meter in METERS {
        let fields = serde_json::json!({"key_name": meter, "reporting_frequency": "RunPeriod"});
        model.insert("Output:Meter:MeterFileOnly", meter, fields);
    }
    for name in model.names("OutputControl:Files") {
        if let Some(files) = model.get_mut("OutputControl:Files", &name) {
            files.insert("output_mtr".into(), "Yes".into());
        }
    }
}

/// A run-period value from the text of a meter file: `12,1,Electricity:HVAC [J] !RunPeriod …` names the number
/// under which the value stands, `12,123.4,…`.
fn run_period_value(text: &str, meter: &str) -> Option<f64> {
    let named = format!(",{meter} [J] !RunPeriod");
    let number = text.lines().find(|line| line.contains(&named))?.split(',').next()?;
    let value = text.lines().skip_while(|line| !line.starts_with("End of Data Dictionary"));
    let mut fields = value.map(|line| line.split(',')).find(|f| f.clone().next() == Some(number))?;
    fields.nth(1)?.trim().parse().ok()
}
