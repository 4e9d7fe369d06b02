//! The scale of rewards, and the baselines that it comes from.

use std::collections::HashMap;
use std::sync::Arc;

use b2b_building::Period;
use b2b_dataset::{BuildingName, Catalog, Control};
use b2b_energyplus::install::Quiet;
use b2b_env::{Spaces, Task};
use b2b_evaluate::{Baseline, Baselines, EpisodePlan, Evaluation, Subject};
use b2b_workers::Launcher;

use super::days;
use super::sampling::{Environments, Evaluated};
use crate::error::Result;
use crate::fragments::RewardScale;
use crate::train::config::TrainConfig;

/// Smallest mean penalty by which rewards are divided, K²: a deviation of 0.02 K.
const SMALLEST_PENALTY: f64 = 4e-4;

impl Environments<'_> {
    /// Returns the factors of rewards: 1 over the baseline's mean penalty per step in the building under the task in
    /// the run period. A building drawn from many gets the median factor of the evaluated buildings, because its own
    /// baseline would have to be run first. Graph networks, whose buildings differ more, use the building's own factor:
    /// see [`DrawnScale`].
    pub(crate) fn scale(&self, evaluation: &Evaluation<'_>, baselines: &Baselines) -> Result<RewardScale> {
        if !self.config.rewards.scale_rewards {
            return Ok(Box::new(|_: &Spaces| Ok(1.0)));
        }
        if self.config.agent.interface().nodes.is_some() && !self.config.training_set.building_type.is_empty()
        {
            let scale = DrawnScale {
                config: self.config.clone(),
                catalog: Arc::clone(&self.catalog),
                launcher: evaluation.launcher.clone(),
                interrupted: evaluation.interrupted,
                baselines: Baselines::open()?,
            };
            return Ok(Box::new(move |spaces: &Spaces| scale.of(spaces)));
        }
        let known = match self.config.training_set.building_type.is_empty() {
            true => self.in_every_way(self.config.training_set.named()?)?,
            false => self.evaluated()?,
        };
        let is_drawn = self.config.training_set.fault_seeds > 0;
        let mut scales: HashMap<(String, Period), HashMap<String, f64>> = HashMap::new();
        for Evaluated { name, task, period } in known {
            let scale = self.scale_of(&name, &task, period, evaluation, baselines)?;
            scales.entry((key_of(&task, is_drawn), period)).or_default().insert(name.to_string(), scale);
        }
        let config = self.config.clone();
        Ok(Box::new(move |spaces: &Spaces| {
            let period = days::period_of(&config, &spaces.episode)?;
            let of_task = &scales[&(key_of(&spaces.episode.task, is_drawn), period)];
            let (name, _) = Control::split_name(&spaces.building.name);
            Ok(of_task.get(name).copied().unwrap_or_else(|| median(of_task)))
        }))
    }

    fn scale_of(
        &self,
        name: &BuildingName,
        task: &Task,
        period: Period,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
    ) -> Result<f64> {
        let (episode, baseline) = self.scored(name, task, period, evaluation, baselines)?;
        let mean = -baseline.episode_return / episode.steps() as f64;
        Ok(1.0 / mean.max(SMALLEST_PENALTY))
    }

    /// Returns the episode of a building over a period, and its baseline, which is computed if unknown.
    pub(crate) fn scored(
        &self,
        name: &BuildingName,
        task: &Task,
        period: Period,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
    ) -> Result<(EpisodePlan, Baseline)> {
        let subject = Subject { name: name.clone(), placement: self.config.training_set.placement()? };
        let site = subject.locate(&self.catalog, &mut Quiet)?;
        let (task, steps_per_hour) = (task.clone(), self.config.training_set.steps_per_hour);
        let episode = EpisodePlan { subject, task, period, seed: 0, steps_per_hour };
        let baseline = baselines.baseline(evaluation, &episode, &site, &())?;
        Ok((episode, baseline))
    }
}

/// The factors of rewards of drawn buildings: 1 over the mean penalty per step of the baseline in the building, over
/// the days of an evaluation in the episode's run period. The baseline runs when a building is first drawn, and is then
/// cached.
struct DrawnScale {
    config: TrainConfig,
    catalog: Arc<Catalog>,
    launcher: Launcher,
    interrupted: fn() -> bool,
    baselines: Baselines,
}

impl DrawnScale {
    fn of(&self, spaces: &Spaces) -> Result<f64> {
        let Self { config, catalog, launcher, interrupted, baselines } = self;
        let environments = Environments::new(config, Arc::clone(catalog));
        let (launcher, interrupted) = (launcher.clone(), *interrupted);
        let evaluation = Evaluation { catalog, launcher, jobs: 1, interrupted };
        let (name, task) = (Control::split_name(&spaces.building.name).0.parse()?, &spaces.episode.task);
        let period = days::evaluated(config, days::period_of(config, &spaces.episode)?);
        environments.scale_of(&name, task, period, &evaluation, baselines)
    }
}

/// Returns what identifies a task: its hash, without the seed of its faults if that is drawn.
fn key_of(task: &Task, is_drawn: bool) -> String {
    let mut task = task.clone();
    if is_drawn {
        task.faults.seed = 0;
    }
    task.hash()
}

/// Returns the median scale; of an even number, the upper of the two middle ones.
fn median(scales: &HashMap<String, f64>) -> f64 {
    let mut sorted: Vec<f64> = scales.values().copied().collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}
