//! One episode from reset to truncation, with a progress bar.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use b2b_control::Controller;
use b2b_env::{Env, Trajectory};
use cpu_time::ProcessTime;

use crate::interrupt;
use crate::progress::{Days, date_text};

/// A complete episode.
pub struct Rollout {
    /// Every step.
    pub trajectory: Trajectory,
    /// The controlled zones that are never occupied.
    pub never_occupied: Vec<String>,
    /// CPU time within `Env::reset` and `Env::step`: the engine, and what the environment adds to it.
    pub env_cpu: Duration,
    /// Wall-clock time from the first step to the last.
    pub wall: Duration,
}

/// Runs an episode to its end. Errors if it is interrupted.
pub fn roll_out(env: &mut Env, controller: &mut dyn Controller, quiet: bool) -> Result<Rollout> {
    let days = Days::new(env.episode().period, env.episode().steps_per_hour, quiet);
    let mut trajectory = Trajectory::for_episode(env.spaces());
    let mut action = vec![0.0; env.action_space().len()];
    let mut env_cpu = Duration::ZERO;
    controller.reset();
    let before = ProcessTime::now();
    env.reset()?;
    env_cpu += before.elapsed();
    let never_occupied = env.never_occupied().map(str::to_owned).collect();
    let mut observation = env.observation();
    days.start();
    let start = Instant::now();
    loop {
        if interrupt::requested() {
            let steps = trajectory.len();
            bail!("interrupted after {steps} steps ({})", date_text(days.date(steps)));
        }
        controller.act(observation, &mut action);
        let before = ProcessTime::now();
        let step = env.step(&action)?;
        env_cpu += before.elapsed();
        trajectory.push(&step);
        days.step(trajectory.len());
        if step.truncated {
            return Ok(Rollout { trajectory, never_occupied, env_cpu, wall: start.elapsed() });
        }
        observation = step.observation;
    }
}
