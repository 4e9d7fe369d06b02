//! The training environments of a configuration.

use std::collections::HashMap;
use std::sync::Arc;

use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{EpisodeConfig, Spaces, Task};
use b2b_evaluate::{Baseline, Baselines, Episode, Evaluation, Subject};
use b2b_workers::{
    Autoreset, Buildings, Kept, Launcher, Population, Rotating, RoundRobin, Sampler, Setting, Source, VecEnv,
    VecEnvOptions, Weighted, Windows, WithTask, WorkerOptions,
};

use super::config::{Algorithm, TrainConfig};
use super::days;
use super::paired::Paired;
use super::staggered::Staggered;
use crate::error::{Error, Result};
use crate::fragments::{FragmentCollector, GraphBuilding, RewardScale};
use crate::lockstep::LockstepCollector;
use crate::rollout::Widths;

/// Smallest mean penalty of a baseline that rewards are divided by, K²: a deviation of 0.02 K.
const SMALLEST_PENALTY: f64 = 4e-4;

/// Makes the environments of a configuration.
pub(super) struct Environments<'a> {
    config: &'a TrainConfig,
    catalog: Arc<Catalog>,
}

impl<'a> Environments<'a> {
    pub(super) fn new(config: &'a TrainConfig, catalog: Arc<Catalog>) -> Self {
        Self { config, catalog }
    }

    /// Returns the batch of training environments, before its first reset.
    fn vector(&self, workers: WorkerOptions) -> Result<VecEnv> {
        let options = VecEnvOptions { workers, autoreset: Autoreset::Disabled, widths: None };
        Ok(VecEnv::new(self.config.environments, self.sampler()?, options)?)
    }

    /// Returns a collector of fragments in the batch, with the first episodes begun.
    pub(super) fn fragments(&self, workers: WorkerOptions, scale: RewardScale) -> Result<FragmentCollector> {
        let Self { config, .. } = self;
        let mut collector = FragmentCollector::new(
            self.vector(workers)?,
            config.interface(),
            config.credit_by_zone,
            config.noise_correlation,
            config.travel_cost,
            scale,
            config.seed,
        )?;
        self.room()?.into_iter().for_each(|widths| collector.make_room(widths));
        Ok(match config.mirrored_noise {
            true => collector.with_mirrored_noise(),
            false => collector,
        })
    }

    /// Returns the widths of one building of every shape that may be drawn, for graph networks.
    fn room(&self) -> Result<Vec<Widths>> {
        let interface = self.config.interface();
        if interface.nodes.is_none() {
            return Ok(Vec::new());
        }
        let mut all = Vec::new();
        for building_type in self.config.building_types()? {
            let buildings = self.population(building_type, self.config.run_period()?)?;
            for (name, building) in buildings.population.representatives()? {
                let setting = buildings.setting(name.clone(), &building)?;
                let found = self.catalog.find(&name.parse()?, &Placement::default(), &mut Quiet)?;
                let prepared = Arc::new(found.prepare(self.catalog.library())?);
                let spaces = Arc::new(Spaces::new(prepared, setting.episode));
                let building = GraphBuilding::of(interface, self.config.credit_by_zone, &spaces)?;
                all.extend(building.map(|building| building.widths()));
            }
        }
        Ok(all)
    }

    fn population(&self, building_type: BuildingType, period: RunPeriod) -> Result<Buildings> {
        Ok(Buildings {
            catalog: Arc::clone(&self.catalog),
            population: Population::Ids(self.config.drawn(building_type).collect()),
            period,
            steps_per_hour: self.config.steps_per_hour,
            task: self.config.task.as_slice()[0].clone(),
        })
    }

    /// Returns a collector in lockstep in the batch, with the first episodes begun.
    pub(super) fn lockstep(&self, workers: WorkerOptions, scale: RewardScale) -> Result<LockstepCollector> {
        let Self { config, .. } = self;
        if config.credit_by_zone {
            let why = "`credit_by_zone` is for fragments; in lockstep it must be false";
            return Err(Error::Invalid(why.into()));
        }
        if config.travel_cost > 0.0 {
            let why = "`travel_cost` requires the loop design fragments; in lockstep it must be 0";
            return Err(Error::Invalid(why.into()));
        }
        if config.mirrored_noise {
            let why = "`mirrored_noise` requires the loop design fragments; in lockstep it must be false";
            return Err(Error::Invalid(why.into()));
        }
        LockstepCollector::new(
            self.vector(workers)?,
            config.interface(),
            config.noise_correlation,
            scale,
            config.seed,
        )
    }

    /// Returns the sampler of training episodes.
    fn sampler(&self) -> Result<Box<dyn Sampler>> {
        let one = || self.sampler_for(self.config.distinct_environments());
        Ok(match self.config.mirrored_noise {
            true => Box::new(Paired::new([one()?, one()?], self.config.seed)),
            false => one()?,
        })
    }

    /// Returns the sampler for a number of environments: in each part of the run period that episodes may be in, windows of some days.
    fn sampler_for(&self, environments: usize) -> Result<Box<dyn Sampler>> {
        let (parts, settings) = (days::trained(self.config)?, self.settings()?);
        let all: u32 = parts.iter().map(|part| part.days()).sum();
        let mut samplers = Vec::new();
        for part in parts {
            let starts = (self.config.window_starts * part.days()).div_ceil(all);
            samplers.push((f64::from(starts), self.part(part, starts, &settings, environments)?));
        }
        let all: Box<dyn Sampler> = match samplers.len() {
            1 => samplers.remove(0).1,
            _ => Box::new(Weighted::new(samplers)?),
        };
        let is_whole_days = self.config.ppo.n_steps.is_multiple_of(24 * self.config.steps_per_hour as usize);
        Ok(match self.config.algorithm == Algorithm::Ppo && !is_whole_days {
            true => Box::new(Staggered::new(all, environments)),
            false => all,
        })
    }

    /// Returns the sampler of windows that begin on a number of days of a part of the run period.
    fn part(
        &self,
        part: RunPeriod,
        starts: u32,
        settings: &[Setting],
        environments: usize,
    ) -> Result<Box<dyn Sampler>> {
        let buildings = self.buildings(part, settings, environments)?;
        let buildings = match self.config.task.as_slice() {
            [_] => buildings,
            tasks => Box::new(WithTask { of: buildings, tasks: tasks.to_vec() }),
        };
        let days = self.config.window_days;
        if days == 0 {
            return Ok(buildings);
        }
        Ok(Box::new(Windows { of: buildings, days: (days, days), starts }))
    }

    /// Returns the sampler of the buildings over all days of a part of the run period.
    fn buildings(
        &self,
        period: RunPeriod,
        settings: &[Setting],
        environments: usize,
    ) -> Result<Box<dyn Sampler>> {
        let types = self.config.building_types()?;
        if !types.is_empty() {
            let of_type = |building_type: &BuildingType| -> Result<Box<dyn Sampler>> {
                Ok(Box::new(self.population(*building_type, period)?))
            };
            let all = RoundRobin(types.iter().map(of_type).collect::<Result<_>>()?);
            return Ok(Box::new(Kept::new(all, self.config.building_episodes)));
        }
        let mut settings = settings.to_vec();
        settings.iter_mut().for_each(|setting| setting.episode.period = period);
        Ok(Box::new(Rotating::new(settings, environments)))
    }

    /// Returns the settings of the buildings that are named, over the whole run period.
    fn settings(&self) -> Result<Vec<Setting>> {
        let (period, steps_per_hour) = (self.config.run_period()?, self.config.steps_per_hour);
        let (task, placement) = (&self.config.task.as_slice()[0], self.config.placement()?);
        let setting = |name: &BuildingName| {
            let found = self.catalog.find(name, &placement, &mut Quiet)?;
            let weather = found.weather.clone();
            let episode = EpisodeConfig { weather, period, steps_per_hour, task: task.clone() };
            Ok(Setting::new(Source::from(found), episode))
        };
        self.config.named()?.iter().map(setting).collect()
    }

    /// Returns what the agent is evaluated on during training: training buildings, evenly spread, each with every task.
    pub(super) fn evaluated(&self) -> Result<Vec<(BuildingName, Task)>> {
        let all: Vec<BuildingName> = match &self.config.building_types()?[..] {
            [] => self.config.named()?,
            types => types.iter().flat_map(|each| self.config.drawn(*each)).map(BuildingName::Id).collect(),
        };
        let count = self.config.evaluation.buildings.clamp(1, all.len());
        let spread = (0..count).map(|index| all[index * all.len() / count].clone()).collect();
        Ok(self.with_every_task(spread))
    }

    fn with_every_task(&self, names: Vec<BuildingName>) -> Vec<(BuildingName, Task)> {
        let tasks = self.config.task.as_slice();
        let with = |name: BuildingName| tasks.iter().map(move |task| (name.clone(), task.clone()));
        names.into_iter().flat_map(with).collect()
    }

    /// Returns the factors of rewards: 1 over the mean penalty per step of the reactive controllers in the building under the
    /// task. For a building drawn from many it is the median of those of the evaluated ones, because a baseline of its own
    /// would have to be run first; only for graph networks, whose buildings differ more, it is that of the building: see
    /// [`DrawnScale`].
    pub(super) fn scale(&self, evaluation: &Evaluation<'_>, baselines: &Baselines) -> Result<RewardScale> {
        if !self.config.scale_rewards {
            return Ok(Box::new(|_: &Spaces| Ok(1.0)));
        }
        if self.config.interface().nodes.is_some() && !self.config.building_type.is_empty() {
            let scale = DrawnScale {
                config: self.config.clone(),
                catalog: Arc::clone(&self.catalog),
                launcher: evaluation.launcher.clone(),
                interrupted: evaluation.interrupted,
                baselines: Baselines::open()?,
            };
            return Ok(Box::new(move |spaces: &Spaces| scale.of(spaces)));
        }
        let known = match self.config.building_type.is_empty() {
            true => self.with_every_task(self.config.named()?),
            false => self.evaluated()?,
        };
        let period = self.config.run_period()?;
        let mut scales: HashMap<String, HashMap<String, f64>> = HashMap::new();
        for (name, task) in known {
            let scale = self.scale_of(&name, &task, period, evaluation, baselines)?;
            scales.entry(task.hash()).or_default().insert(name.to_string(), scale);
        }
        Ok(Box::new(move |spaces: &Spaces| {
            let of_task = &scales[&spaces.episode.task.hash()];
            Ok(of_task.get(&spaces.building.name).copied().unwrap_or_else(|| median(of_task)))
        }))
    }

    fn scale_of(
        &self,
        name: &BuildingName,
        task: &Task,
        period: RunPeriod,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
    ) -> Result<f64> {
        let (episode, baseline) = self.scored(name, task, period, evaluation, baselines)?;
        let mean = -baseline.episode_return / episode.steps() as f64;
        Ok(1.0 / mean.max(SMALLEST_PENALTY))
    }

    /// Returns the episode of a building over a period, and what it is scored against, which is computed if it is unknown.
    pub(super) fn scored(
        &self,
        name: &BuildingName,
        task: &Task,
        period: RunPeriod,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
    ) -> Result<(Episode, Baseline)> {
        let subject = Subject { name: name.clone(), placement: self.config.placement()? };
        let site = subject.locate(&self.catalog, &mut Quiet)?;
        let (task, steps_per_hour) = (task.clone(), self.config.steps_per_hour);
        let episode = Episode { subject, task, period, seed: 0, steps_per_hour };
        let baseline = baselines.baseline(evaluation, &episode, &site, &())?;
        Ok((episode, baseline))
    }
}

/// The factors of rewards of drawn buildings: 1 over the mean penalty per step of the reactive controllers in the building, over
/// the days of an evaluation. An episode of them runs when a building is first drawn, and is kept in the cache of baselines.
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
        let (name, task) = (spaces.building.name.parse()?, &spaces.episode.task);
        environments.scale_of(&name, task, days::evaluated(config)?, &evaluation, baselines)
    }
}

/// Returns the median scale, of an even number the upper one of the two in the middle.
fn median(scales: &HashMap<String, f64>) -> f64 {
    let mut sorted: Vec<f64> = scales.values().copied().collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;
    use crate::ppo::PpoConfig;

    #[test]
    fn named_buildings_beyond_the_number_of_environments_are_trained_on_too() {
        let catalog = Arc::new(Catalog::open(&mut Quiet).unwrap());
        let names: Vec<String> = (1..=5).map(|number| format!("SingleFamilyHouse-{number:04}")).collect();
        for (environments, mirrored_noise) in [(2, false), (4, true)] {
            let buildings = names.clone();
            let config = TrainConfig { buildings, environments, mirrored_noise, ..TrainConfig::default() };
            let mut sampler = Environments::new(&config, Arc::clone(&catalog)).sampler().unwrap();
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(0);
            let mut drawn = |environment: usize| {
                let source = sampler.draw(environment, &mut random).unwrap().setting.source;
                names.iter().position(|name| source.name() == *name).unwrap()
            };
            let of_first: Vec<usize> = (0..4).map(|_| drawn(0)).collect();
            let of_last: Vec<usize> = (0..4).map(|_| drawn(environments - 1)).collect();
            assert_eq!((of_first, of_last), (vec![0, 2, 4, 0], vec![1, 3, 0, 1]));
        }
    }

    #[test]
    fn no_training_episode_has_a_day_of_the_evaluations() {
        let catalog = Arc::new(Catalog::open(&mut Quiet).unwrap());
        // Rollouts of whole days: all episodes are whole windows.
        let ppo = PpoConfig { n_steps: 288, ..PpoConfig::default() };
        let all = TrainConfig { ppo, ..TrainConfig::default() };
        let named = TrainConfig { buildings: vec!["OfficeSmall-0042".into()], ..all.clone() };
        let drawn = TrainConfig { building_type: vec!["OfficeSmall".into()], ..all };
        for config in [named, drawn] {
            let config = TrainConfig { window_days: 14, window_starts: 6, ..config };
            let day = |date: b2b_building::Date| date.day_of_year();
            let held_out = days::evaluated(&config).unwrap();
            let mut sampler = Environments::new(&config, Arc::clone(&catalog)).sampler().unwrap();
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(0);
            let mut first_days: Vec<u32> = Vec::new();
            for _ in 0..40 {
                let draw = sampler.draw(0, &mut random).unwrap();
                let period = draw.setting.episode.period;
                assert_eq!((period.days(), draw.steps), (14, Some(14 * 288)));
                let is_apart = period.last() < held_out.first() || period.first() > held_out.last();
                assert!(is_apart, "{period} has days of {held_out}");
                first_days.push(day(period.first()));
            }
            first_days.sort_unstable();
            first_days.dedup();
            assert_eq!(first_days, [1, 13, 25, 53, 65, 77], "six first days");
        }
    }
}
