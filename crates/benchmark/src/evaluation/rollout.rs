//! One episode, from its first step to its last.

use std::sync::Arc;

use b2b_control::Controller;
use b2b_env::Trajectory;
use b2b_env::vector::{Live, Pool, Start};

use super::bench::Bench;
use super::episode::Episode;
use super::finished::Finished;
use super::info::EpisodeInfo;
use super::parallel::Work;
use super::recording::Recording;
use crate::policy::{EpisodeContext, Interface};
use crate::{Error, Result};

/// Runs an episode.
pub(super) fn run(bench: &mut Bench, episode: &Episode, work: &Work<'_>) -> Result<Finished> {
    let setting = bench.setting(episode);
    let template = bench.pool.prepare(&setting)?;
    let spaces = bench.pool.spaces(template)?;
    let mut controller = work.policy.controller(EpisodeContext {
        subject: &bench.located.subject,
        site: &bench.located.site,
        spaces: &spaces,
        interface: &Interface::of(&spaces),
        seed: episode.seed,
        pool: &mut bench.pool,
        template,
    })?;
    let mut live = bench.pool.begin(template, Start::default())?;
    let rolled_out = roll_out(&mut bench.pool, &mut live, controller.as_mut(), work);
    let metrics = bench.pool.metrics(&live);
    bench.pool.stop(live);
    let rolled = rolled_out?;
    let metrics = metrics.ok_or(gone("it left no metrics"))?;
    let info = EpisodeInfo::of_run(episode, work.policy, &spaces, &bench.located.site);
    let finished = Finished::new(info, &spaces, &metrics, &rolled);
    bench.prepared.get_or_insert_with(|| Arc::clone(&spaces.building));
    Ok(finished)
}

/// Every step of an episode that begins. The first observation goes before those of the steps.
fn roll_out(
    pool: &mut Pool,
    live: &mut Live,
    controller: &mut dyn Controller,
    work: &Work<'_>,
) -> Result<Recording> {
    let spaces = Arc::clone(live.spaces());
    let (steps, steps_a_day) = (spaces.episode_steps(), 24 * spaces.episode.steps_per_hour as usize);
    let mut observation = vec![0.0; spaces.observation.len()];
    let mut action = vec![0.0; spaces.action.len()];
    let mut trajectory = Trajectory {
        observations: Vec::with_capacity(steps * observation.len()),
        actions: Vec::with_capacity(steps * action.len()),
        penalties: Vec::with_capacity(steps),
    };
    controller.reset();
    stand(pool, live)?;
    pool.observation(live, &mut observation);
    let first_observation = observation.clone();
    while !live.is_truncated() {
        if trajectory.len().is_multiple_of(steps_a_day) {
            work.check()?;
        }
        controller.act(&observation, &mut action);
        pool.send(live, &action)?;
        stand(pool, live)?;
        pool.observation(live, &mut observation);
        pool.action(live, &mut action);
        let reward = pool.reward(live);
        trajectory.observations.extend_from_slice(&observation);
        trajectory.actions.extend_from_slice(&action);
        trajectory.penalties.push([reward.temperature_penalty, reward.energy_penalty]);
        if trajectory.len().is_multiple_of(steps_a_day) {
            work.progress.day();
        }
    }
    Ok(Recording { first_observation, trajectory })
}

/// Waits for a process to be done with what it does.
fn stand(pool: &mut Pool, live: &mut Live) -> Result<()> {
    pool.wait(std::slice::from_mut(live), 1)?;
    match live.lost() {
        None => Ok(()),
        Some(why) => Err(gone(why)),
    }
}

fn gone(why: &str) -> Error {
    b2b_env::Error::Gone { what: "the environment", why: why.to_owned() }.into()
}
