//! Readings of an episode: metrics, and the engine's messages, meters and variables.

use b2b_energyplus::{Clock, Level, Messages};

use super::engine::Engine;
use super::{Env, meters};
use crate::Result;
use crate::engine_report::EngineReport;
use crate::metrics::Metrics;

/// Severe messages in an [`EngineReport`].
const SEVERES_KEPT: usize = 5;

impl Env {
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
    /// [`Error::Io`](crate::Error::Io) before the end of the run period, when the engine writes them.
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

    /// The heating rate under a heating setpoint, or the cooling rate under a cooling setpoint, in the last step, W.
    /// `None` for actuators without one and in the cases of [`Env::effect`].
    pub fn heat(&self, actuator: usize) -> Option<f64> {
        let engine = self.engine.as_ref()?;
        engine.heats.get(actuator).copied().flatten().map(|variable| engine.simulation.read(variable))
    }

    /// The outdoor air mass flow of each system at the end of the last step, kg/s, and the people in its zones; `None`
    /// for a system without outdoor air. Empty without an episode in progress.
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
}
