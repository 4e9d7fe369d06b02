//! One episode from reset to truncation, with a progress bar.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use b2b_building::{Date, RunPeriod};
use b2b_climate::EpwFile;
use b2b_env::{
    Controller, DecisionLog, EngineReport, Environment, Metrics, Observer, Spaces, Step, Task, Trajectory,
    authority, rollout,
};
use b2b_workers::EpisodeReport;
use cpu_time::ProcessTime;

use crate::program::prepare::Prepared;
use crate::terminal::interrupt;
use crate::terminal::progress::{Days, date_text};

/// A complete episode with the report of its engine.
pub struct Rollout {
    /// Metrics of the episode.
    pub metrics: Metrics,
    /// Every step.
    pub trajectory: Trajectory,
    /// The controller's decisions behind every action; none for an episode that was stepped from outside.
    pub decisions: DecisionLog,
    /// Messages, meters and occupancy of the engine's run.
    pub engine: EngineReport,
    /// CPU time of the environment, including the engine.
    pub env_cpu: Duration,
    /// CPU time of this process and of the environment's process.
    pub total_cpu: Duration,
    /// Wall-clock time from the first step to the last.
    pub wall: Duration,
}

impl Rollout {
    /// Combines an episode with the report of its worker. The CPU time of this process is counted up to now.
    pub fn new(metrics: Metrics, trajectory: Trajectory, report: EpisodeReport, wall: Duration) -> Self {
        let EpisodeReport { engine, cpu: env_cpu } = report;
        let total_cpu = ProcessTime::now().as_duration() + env_cpu;
        let decisions = DecisionLog::default();
        Self { metrics, trajectory, decisions, engine, env_cpu, total_cpu, wall }
    }
}

impl Prepared {
    /// Runs an episode of this building to its end in a worker process, so that a crash of the engine becomes an error.
    pub fn roll_out(&self, spaces: &Spaces, controller: &mut dyn Controller, quiet: bool) -> Result<Rollout> {
        use anyhow::Context;
        use b2b_workers::{EpisodeOptions, Workers};

        let workers = Workers::new(self.worker_options())?;
        let options = EpisodeOptions { finish_run: true, ..EpisodeOptions::default() };
        let mut episode = workers.episode(&self.setting(spaces.episode.clone()))?.with_options(options);
        let Recorded { metrics, trajectory, decisions, wall } = roll_out(&mut episode, controller, quiet)?;
        let report = episode.report().context("the worker process sent no engine report")?;
        Ok(Rollout { decisions, ..Rollout::new(metrics, trajectory, report.clone(), wall) })
    }

    /// Checks the response of the building to its actuators, in a worker process.
    pub fn authority(&self) -> Result<authority::Report> {
        Ok(b2b_workers::Jobs::new(self.worker_options()).authority(&self.building, &self.weather)?)
    }

    /// Starts an episode of one day, the first of the year that the weather file has, up to its first observation:
    /// EnergyPlus detects some errors of a model only when it simulates.
    pub fn check_start(&self) -> Result<()> {
        let file = EpwFile::open(&self.weather)?;
        let first = (1..=365)
            .map(Date::of_day)
            .find(|date| file.record().is_ok_and(|record| record.has(date.month_and_day())));
        let first = first.unwrap_or(Date::of_day(1));
        let (period, steps, task) = (RunPeriod::new(first, first), self.trial_steps()?, Task::default());
        let workers = b2b_workers::Workers::new(self.worker_options())?;
        let spaces = self.spaces(period, steps, task)?;
        workers.episode(&self.setting(spaces.episode))?.reset()?;
        Ok(())
    }

    /// Returns the steps per hour of a trial: 12, or the rows of an hour in the weather file if it has several.
    pub fn trial_steps(&self) -> Result<u32> {
        let rows = EpwFile::open(&self.weather)?.record()?.intervals();
        Ok(if rows > 1 { rows } else { 12 })
    }
}

/// A complete episode.
pub struct Recorded {
    /// Metrics of the episode.
    pub metrics: Metrics,
    /// Every step.
    pub trajectory: Trajectory,
    /// The controller's decisions behind every action.
    pub decisions: DecisionLog,
    /// Wall-clock time from the first step to the last.
    pub wall: Duration,
}

/// Runs an episode to its end. Errors if it is interrupted.
pub fn roll_out(
    environment: &mut dyn Environment,
    controller: &mut dyn Controller,
    quiet: bool,
) -> Result<Recorded> {
    let spaces = environment.spaces().clone();
    let mut trajectory = Trajectory::for_episode(&spaces);
    let mut decisions = DecisionLog::for_episode(controller, spaces.episode_steps());
    let days = Days::new(spaces.episode.period, spaces.episode.steps_per_hour, quiet);
    let mut progress = Progress { days, steps: 0, began: Instant::now() };
    let mut recorders = (&mut trajectory, &mut decisions);
    match rollout(environment, controller, &mut (&mut recorders, &mut progress)) {
        Ok(metrics) => Ok(Recorded { metrics, trajectory, decisions, wall: progress.began.elapsed() }),
        Err(b2b_env::Error::Interrupted) => {
            let steps = trajectory.len();
            bail!("interrupted after {steps} steps ({})", date_text(progress.days.date(steps)))
        }
        Err(error) => Err(error.into()),
    }
}

/// Shows the progress in simulated days, and ends the episode on an interrupt.
struct Progress {
    days: Days,
    steps: usize,
    began: Instant,
}

impl Progress {
    fn check_interrupt() -> b2b_env::Result<()> {
        if interrupt::requested() { Err(b2b_env::Error::Interrupted) } else { Ok(()) }
    }
}

impl Observer for Progress {
    fn begin(&mut self, _: &[f64]) -> b2b_env::Result<()> {
        self.days.start();
        self.began = Instant::now();
        Self::check_interrupt()
    }

    fn step(&mut self, _: &Step<'_>) -> b2b_env::Result<()> {
        self.steps += 1;
        self.days.step(self.steps);
        Self::check_interrupt()
    }
}
