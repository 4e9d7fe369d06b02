//! An episode in a worker process.

pub(crate) mod environment;
pub(crate) mod episode_options;
pub(crate) mod episode_report;
pub(crate) mod metrics_report;
mod snapshot;

use std::sync::Arc;

use serde::Serialize;
use serde_json::value::to_raw_value;

use self::episode_options::EpisodeOptions;
use self::episode_report::EpisodeReport;
pub use self::snapshot::Snapshot;
use super::order::{FragmentOrder, Order};
use super::pool::SlotPlace;
use super::region::{Command, LONG_ORDER, Region, Status};
use super::setting::EpisodeSetting;
use super::time_limit::TimeLimit;
use super::workers::Workers;
use b2b_env::{Amounts, Error, Metrics, Result, Reward, Spaces, Step, from_numbers};

/// Number of failed copies of a template that are replaced before the episode is lost.
const FAILED_STARTS: u32 = 3;

/// An environment in a worker process, which it owns: dropping it ends the process.
///
/// - [`reset`](b2b_env::Environment::reset) copies the template of its setting, within milliseconds.
/// - [`Episode::snapshot`], [`Episode::restore`] and [`Episode::branch`] copy the process mid-episode; every copy
///   continues bit for bit.
/// - A crash of the engine, a kill or a hang is [`Error::Lost`] with the reason; a reset recovers.
/// - [`Episode::begin`] and [`Episode::send`] do not wait, and [`recv`](super::recv) waits for several at once.
///
/// A step allocates nothing, except at the end of an episode.
#[derive(Debug)]
pub struct Episode {
    workers: Workers,
    setting: EpisodeSetting,
    spaces: Arc<Spaces>,
    options: EpisodeOptions,
    place: Option<SlotPlace>,
    phase: EpisodePhase,
    /// Copies made for the episode that never attached.
    failed_starts: u32,
    observation: Vec<f64>,
    action: Vec<f64>,
    reward: Reward,
    terms: Amounts,
    metrics: Option<Metrics>,
    report: Option<EpisodeReport>,
}

/// State of an episode.
#[derive(Clone, Debug, PartialEq)]
enum EpisodePhase {
    /// Before its first reset.
    New,
    /// Waits for a copy of its template, within a limit once the copy was made.
    Starting(Option<TimeLimit>),
    /// Ready for an action.
    Ready,
    /// In a step, within a limit.
    Stepping(TimeLimit),
    /// At its end.
    Truncated,
    /// Lost, with the reason.
    Lost(String),
}

impl Workers {
    /// Prepares a setting and returns an episode of it, before its first reset.
    ///
    /// # Errors
    /// Same as [`Workers::prepare`].
    pub fn episode(&self, setting: &EpisodeSetting) -> Result<Episode> {
        let spaces = self.prepare(setting)?;
        Ok(Episode::new(self.clone(), setting.clone(), spaces))
    }
}

impl Episode {
    pub(super) fn new(workers: Workers, setting: EpisodeSetting, spaces: Arc<Spaces>) -> Self {
        Self {
            observation: vec![0.0; spaces.observation.len()],
            action: vec![0.0; spaces.action.len()],
            workers,
            setting,
            spaces,
            options: EpisodeOptions::default(),
            place: None,
            phase: EpisodePhase::New,
            failed_starts: 0,
            reward: Reward::default(),
            terms: Amounts::default(),
            metrics: None,
            report: None,
        }
    }

    /// Sets how the episode is run.
    #[must_use]
    pub fn with_options(mut self, options: EpisodeOptions) -> Self {
        self.options = options;
        self
    }

    /// Sets how the episode is run from its next reset on.
    pub fn set_options(&mut self, options: EpisodeOptions) {
        self.options = options;
    }

    /// Begins an episode like [`reset`](b2b_env::Environment::reset), without waiting for its first observation.
    ///
    /// # Errors
    /// [`Error::Pool`] when no process can be started.
    pub fn begin(&mut self) -> Result<()> {
        self.failed_starts = 0;
        self.ask_for_copy()
    }

    fn ask_for_copy(&mut self) -> Result<()> {
        self.end();
        self.phase = EpisodePhase::New;
        (self.metrics, self.report) = (None, None);
        (self.reward, self.terms) = (Reward::default(), Amounts::default());
        self.place = Some(self.workers.lock().start(&self.setting, self.options)?);
        self.phase = EpisodePhase::Starting(None);
        Ok(())
    }

    /// Sends an action to a ready episode, without waiting for the step.
    ///
    /// # Errors
    /// [`Error::ActionLength`] and [`Error::ActionNotFinite`] before anything is sent; [`Error::NotReset`];
    /// [`Error::Busy`]; [`Error::Lost`].
    pub fn send(&mut self, action: &[f64]) -> Result<()> {
        let slot = self.check(action)?;
        self.workers.region().write_action(slot, action);
        self.workers.region().command(slot, Command::Step);
        self.phase = EpisodePhase::Stepping(TimeLimit::new(self.workers.step_time_limit()));
        Ok(())
    }

    /// Checks that [`Episode::send`] accepts an action now. Returns the slot.
    ///
    /// # Errors
    /// Same as [`Episode::send`].
    pub(super) fn check(&self, action: &[f64]) -> Result<u32> {
        let slot = self.slot()?;
        self.spaces.action.check(action)?;
        Ok(slot)
    }

    /// Requests a fragment of about `steps` steps from the worker's [`Runner`](super::Runner) of this kind, without
    /// waiting for it. An order too long for shared memory, for example an agent of a large building, passes through a
    /// file.
    ///
    /// # Errors
    /// [`Error::NotReset`]; [`Error::Busy`]; [`Error::Lost`]; [`Error::Io`] when the file cannot be written.
    pub fn send_fragment(&mut self, runner: &str, order: &impl Serialize, steps: usize) -> Result<()> {
        let slot = self.slot()?;
        let order = to_raw_value(order).expect("an order is plain data");
        let order = Order::Fragment(FragmentOrder { runner: runner.to_owned(), order }).to_json();
        let order = order.map_err(|source| Error::Io { path: runner.into(), source })?;
        let command = if Region::has_room_for(&order) {
            self.workers.region().write_report(slot, &order);
            Command::Fragment
        } else {
            let path = self.workers.lock().file(slot, LONG_ORDER);
            std::fs::write(&path, order).map_err(|source| Error::Io { path, source })?;
            Command::LongFragment
        };
        self.workers.region().command(slot, command);
        // A step is a hundred times faster than its limit.
        let limit = self.workers.step_time_limit() * (1 + steps as u32 / 100);
        self.phase = EpisodePhase::Stepping(TimeLimit::new(limit));
        Ok(())
    }

    /// The number of steps of the last fragment. The episode must not be busy.
    pub fn fragment_steps(&self) -> usize {
        self.place.map_or(0, |place| self.workers.region().fragment_steps(place.slot))
    }

    /// The outcome of the last step. The episode must not be busy.
    ///
    /// # Errors
    /// [`Error::Lost`] when the worker died, hung or failed; [`Error::Busy`]; [`Error::NotReset`].
    pub fn last_step(&self) -> Result<Step<'_>> {
        match &self.phase {
            EpisodePhase::Ready | EpisodePhase::Truncated => Ok(Step {
                observation: &self.observation,
                action: &self.action,
                reward: self.reward,
                terms: self.terms,
                truncated: self.phase == EpisodePhase::Truncated,
            }),
            _ => Err(self.not_ready()),
        }
    }

    /// The set of workers that the episode runs in.
    pub fn workers(&self) -> &Workers {
        &self.workers
    }

    /// The building, weather, period and task.
    pub fn setting(&self) -> &EpisodeSetting {
        &self.setting
    }

    /// The building with its observation and action spaces.
    pub(super) fn known_spaces(&self) -> &Arc<Spaces> {
        &self.spaces
    }

    /// The metrics of the episode once it is truncated.
    pub(super) fn known_metrics(&self) -> Option<&Metrics> {
        self.metrics.as_ref()
    }

    /// The state at the end of the last step, or at the start of the episode.
    pub fn observation(&self) -> &[f64] {
        &self.observation
    }

    /// The reward of the last step.
    pub fn reward(&self) -> Reward {
        self.reward
    }

    /// Energy, cost, emissions and the other terms of the last step.
    pub fn terms(&self) -> Amounts {
        self.terms
    }

    /// Returns whether the worker is busy with a step or with its start.
    pub fn is_busy(&self) -> bool {
        matches!(self.phase, EpisodePhase::Starting(_) | EpisodePhase::Stepping(_))
    }

    /// Returns whether the episode is at its end.
    pub fn is_truncated(&self) -> bool {
        self.phase == EpisodePhase::Truncated
    }

    /// Returns why the episode was lost, if it was.
    pub fn lost(&self) -> Option<&str> {
        match &self.phase {
            EpisodePhase::Lost(why) => Some(why),
            _ => None,
        }
    }

    /// The worker's report at the end of an episode with [`EpisodeOptions::finish_run`].
    pub fn report(&self) -> Option<&EpisodeReport> {
        self.report.as_ref()
    }

    /// The worker process. `None` before it has started.
    pub fn process(&self) -> Option<u32> {
        Some(self.workers.region().process(self.place?.slot)).filter(|process| *process != 0)
    }

    /// The slot of an episode that is ready.
    fn slot(&self) -> Result<u32> {
        match (&self.phase, self.place) {
            (EpisodePhase::Ready, Some(place)) => Ok(place.slot),
            _ => Err(self.not_ready()),
        }
    }

    fn not_ready(&self) -> Error {
        match &self.phase {
            EpisodePhase::Starting(_) | EpisodePhase::Stepping(_) => Error::Busy,
            EpisodePhase::Lost(why) => Error::Lost {
                what: format!("the episode of {}", self.spaces.building.name),
                why: why.clone(),
            },
            EpisodePhase::New | EpisodePhase::Ready | EpisodePhase::Truncated => Error::NotReset,
        }
    }

    pub(super) fn is_starting(&self) -> bool {
        matches!(self.phase, EpisodePhase::Starting(_))
    }

    /// Reads the worker's report, if any. Returns whether the episode is idle.
    pub(super) fn settle(&mut self) -> bool {
        let (true, Some(SlotPlace { slot, .. })) = (self.is_busy(), self.place) else { return true };
        let region = self.workers.region();
        if !region.is_ready(slot) {
            return false;
        }
        let status = region.status(slot);
        if status == Status::Failed {
            self.phase = EpisodePhase::Lost(String::from_utf8_lossy(&region.report(slot)).into_owned());
            return true;
        }
        region.read_observation(slot, &mut self.observation);
        if matches!(self.phase, EpisodePhase::Starting(_)) {
            self.workers.lock().adopt(slot);
        } else {
            region.read_action(slot, &mut self.action);
            (self.reward, self.terms) = from_numbers(region.step_numbers(slot));
        }
        self.phase = EpisodePhase::Ready;
        if status == Status::Truncated {
            self.take_metrics(slot);
        }
        true
    }

    fn take_metrics(&mut self, slot: u32) {
        let folder = self.workers.lock().folder().to_owned();
        let metrics = metrics_report::read(self.workers.region(), slot, &folder);
        if self.options.finish_run {
            let file = self.workers.lock().file(slot, "json");
            let text = std::fs::read(file).ok();
            self.report = text.and_then(|text| serde_json::from_slice(&text).ok());
        }
        match metrics {
            Ok(metrics) => (self.metrics, self.phase) = (Some(metrics), EpisodePhase::Truncated),
            Err(error) => self.phase = EpisodePhase::Lost(format!("its worker left no metrics: {error}")),
        }
    }

    /// Checks whether the worker of a busy episode has ended or exceeded its time limit.
    pub(super) fn check_worker(&mut self) {
        let Some(place) = self.place.filter(|_| self.is_busy()) else { return };
        let mut pool = self.workers.lock();
        if self.phase == EpisodePhase::Starting(None) && !pool.waits_for_template(place) {
            self.phase = EpisodePhase::Starting(Some(TimeLimit::new(self.workers.step_time_limit())));
        }
        let is_late = match &mut self.phase {
            EpisodePhase::Starting(limit) => limit.as_mut().is_some_and(TimeLimit::is_exceeded),
            EpisodePhase::Stepping(limit) => limit.is_exceeded(),
            _ => return,
        };
        let gone = pool.failure(place.slot, is_late);
        drop(pool);
        match gone {
            None => {}
            // A copy that never attached has run nothing and is replaced.
            Some(_)
                if self.is_starting() && self.process().is_none() && self.failed_starts < FAILED_STARTS =>
            {
                self.failed_starts += 1;
                if let Err(error) = self.ask_for_copy() {
                    self.phase = EpisodePhase::Lost(error.to_string());
                }
            }
            Some(why) => self.phase = EpisodePhase::Lost(why),
        }
    }

    /// Ends the worker.
    pub(super) fn end(&mut self) {
        if let Some(place) = self.place.take()
            && self.workers.belong_to_this_process()
        {
            self.workers.lock().release(place);
        }
    }
}

impl Drop for Episode {
    fn drop(&mut self) {
        self.end();
    }
}
