//! The exploration noise that training begins with.

use super::config::TrainConfig;
use crate::collector::Collector as _;
use crate::error::Result;
use crate::fragments::FragmentCollector;
use crate::learner::Learner;
use crate::rollout::Rollout;

/// Logarithms of the standard deviations to choose from, in descending order, and one with almost no noise.
const LOG_STDS: [f32; 8] = [-0.5, -1.0, -1.5, -2.0, -2.5, -3.0, -3.5, -4.0];
const SILENT: f32 = -7.0;
/// Share of the penalty that noise may always cost, because comfort alone would allow almost no noise where energy
/// dominates the penalty.
const SMALLEST_COST: f64 = 0.1;

/// The mean penalty of a step.
struct Penalty {
    all: f64,
    /// The zones' penalty if it is known, otherwise all of it.
    comfort: f64,
}

/// Sets the logarithm of the standard deviation of actions, and returns it: the largest whose noise costs no more than
/// [`NoiseConfig::noise_cost`](super::NoiseConfig::noise_cost) allows, on average over the environments' first day, or
/// the smallest if all cost more. Training then begins with the same day.
///
/// # Errors
/// The errors of the collector.
pub(super) fn calibrate(
    config: &TrainConfig,
    learner: &mut dyn Learner,
    collector: &mut FragmentCollector,
) -> Result<f32> {
    let beginning = collector.state();
    let mut penalty_with = |log_std| {
        learner.set_log_std(log_std);
        collector.restore(&beginning, &learner.actor())?;
        first_day(config, learner, collector)
    };
    let quiet = penalty_with(SILENT)?;
    let affordable = (config.noise.noise_cost - 1.0) * quiet.comfort;
    let limit = quiet.all + affordable.max(SMALLEST_COST * quiet.all);
    // More noise costs more: a bisection.
    let (mut loudest, mut quietest) = (0, LOG_STDS.len() - 1);
    while loudest < quietest {
        let middle = (loudest + quietest) / 2;
        match penalty_with(LOG_STDS[middle])?.all <= limit {
            true => quietest = middle,
            false => loudest = middle + 1,
        }
    }
    learner.set_log_std(LOG_STDS[quietest]);
    collector.restore(&beginning, &learner.actor())?;
    Ok(LOG_STDS[quietest])
}

/// Returns the penalty of the first day of every environment.
fn first_day(
    config: &TrainConfig,
    learner: &dyn Learner,
    collector: &mut FragmentCollector,
) -> Result<Penalty> {
    // One step less than a day: after a day, an episode's memory moves to large pages, which takes longer than the day.
    let steps = 24 * config.training_set.steps_per_hour as usize / config.hold() - 1;
    let mut rollout = Rollout::default();
    collector.collect(&learner.actor(), steps, &mut rollout)?;
    let all = rollout.mean_penalty();
    let energy = match config.rewards.credit_by_zone {
        true => rollout.mean_energy_penalty(collector.widths().parts),
        false => 0.0,
    };
    Ok(Penalty { all, comfort: all - energy })
}
