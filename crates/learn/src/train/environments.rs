//! The training environments of a configuration.

use std::collections::HashMap;
use std::sync::Arc;

use b2b_benchmark::{Baseline, Baselines, Episode, Evaluation, Subject};
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::{BuildingName, Catalog, Placement, Split};
use b2b_energyplus::install::Quiet;
use b2b_env::vector::{
    Autoreset, Buildings, Fixed, InTurn, Kept, Launcher, Population, Sampler, Setting, Source, VecEnv,
    VecEnvOptions, Windows, WorkerOptions,
};
use b2b_env::{EpisodeConfig, Spaces};

use super::config::TrainConfig;
use super::judge::window;
use crate::collector::Widths;
use crate::error::{Error, Result};
use crate::fragments::{FragmentCollector, GraphBuilding, RewardScale};
use crate::lockstep::LockstepCollector;

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
            scale,
            config.seed,
        )?;
        self.room()?.into_iter().for_each(|widths| collector.make_room(widths));
        Ok(collector)
    }

    /// Returns the widths of one building of every shape that may be drawn, for graph networks.
    fn room(&self) -> Result<Vec<Widths>> {
        let interface = self.config.interface();
        if interface.nodes.is_none() {
            return Ok(Vec::new());
        }
        let mut all = Vec::new();
        for building_type in self.config.building_types()? {
            let buildings = self.population(building_type)?;
            for (name, building) in buildings.population.representatives()? {
                let setting = buildings.setting(name.clone(), &building)?;
                let found = self.catalog.find(&name.parse()?, &Placement::default(), &mut Quiet)?;
                let prepared = Arc::new(found.prepare(self.catalog.library())?);
                let spaces = Arc::new(Spaces::new(prepared, setting.episode));
                let widths = GraphBuilding::of(interface, &spaces)?.map(|building| building.widths());
                all.extend(widths.map(|(observation, action)| Widths { observation, action, parts: 1 }));
            }
        }
        Ok(all)
    }

    fn population(&self, building_type: BuildingType) -> Result<Buildings> {
        Ok(Buildings {
            catalog: Arc::clone(&self.catalog),
            population: Population::of_split(building_type, Split::Train),
            period: self.config.run_period()?,
            steps_per_hour: self.config.steps_per_hour,
            task: self.config.task()?,
        })
    }

    /// Returns a collector in lockstep in the batch, with the first episodes begun.
    pub(super) fn lockstep(&self, workers: WorkerOptions, scale: RewardScale) -> Result<LockstepCollector> {
        let Self { config, .. } = self;
        if config.credit_by_zone {
            let why = "`credit_by_zone` is for fragments; in lockstep it must be false";
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

    fn sampler(&self) -> Result<Box<dyn Sampler>> {
        let buildings = self.buildings()?;
        let days = self.config.window_days;
        if days == 0 {
            return Ok(buildings);
        }
        Ok(Box::new(Windows { of: buildings, days: (days, days), starts: self.config.window_starts }))
    }

    /// Returns the sampler of whole run periods.
    fn buildings(&self) -> Result<Box<dyn Sampler>> {
        let (period, steps_per_hour) = (self.config.run_period()?, self.config.steps_per_hour);
        let task = self.config.task()?;
        let types = self.config.building_types()?;
        if !types.is_empty() {
            let of_type = |building_type: &BuildingType| -> Result<Box<dyn Sampler>> {
                Ok(Box::new(self.population(*building_type)?))
            };
            let all = InTurn(types.iter().map(of_type).collect::<Result<_>>()?);
            return Ok(Box::new(Kept::new(all, self.config.building_episodes)));
        }
        let setting = |name: &BuildingName| {
            let found = self.catalog.find(name, &Placement::default(), &mut Quiet)?;
            let weather = found.weather.clone();
            let episode = EpisodeConfig { weather, period, steps_per_hour, task: task.clone() };
            Ok(Setting::new(Source::from(found), episode))
        };
        let settings = self.config.named()?.iter().map(setting).collect::<Result<_>>()?;
        Ok(Box::new(Fixed(settings)))
    }

    /// Returns the buildings that the agent is evaluated on during training: training buildings, evenly spread.
    pub(super) fn evaluated(&self) -> Result<Vec<BuildingName>> {
        let all: Vec<BuildingName> = match &self.config.building_types()?[..] {
            [] => self.config.named()?,
            types => types.iter().flat_map(|each| training_rows(*each)).map(BuildingName::Id).collect(),
        };
        let count = self.config.evaluation.buildings.clamp(1, all.len());
        Ok((0..count).map(|index| all[index * all.len() / count].clone()).collect())
    }

    /// Returns the factors of rewards: 1 over the mean penalty per step of the reactive controllers in the building. For a
    /// building drawn from many it is the median of those of the evaluated ones, because a baseline of its own would have to
    /// be run first; only for graph networks, whose buildings differ more, it is that of the building: see [`DrawnScale`].
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
        let (period, mut scales) = (self.config.run_period()?, HashMap::new());
        for name in self.evaluated_or_named()? {
            scales.insert(name.to_string(), self.scale_of(&name, period, evaluation, baselines)?);
        }
        let mut sorted: Vec<f64> = scales.values().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let of = move |spaces: &Spaces| Ok(scales.get(&spaces.building.name).copied().unwrap_or(median));
        Ok(Box::new(of))
    }

    fn evaluated_or_named(&self) -> Result<Vec<BuildingName>> {
        if self.config.building_type.is_empty() { self.config.named() } else { self.evaluated() }
    }

    fn scale_of(
        &self,
        name: &BuildingName,
        period: RunPeriod,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
    ) -> Result<f64> {
        let (episode, baseline) = self.scored(name, period, evaluation, baselines)?;
        let mean = -baseline.episode_return / episode.steps() as f64;
        Ok(1.0 / mean.max(SMALLEST_PENALTY))
    }

    /// Returns the episode of a building over a period, and what it is scored against, which is computed if it is unknown.
    pub(super) fn scored(
        &self,
        name: &BuildingName,
        period: RunPeriod,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
    ) -> Result<(Episode, Baseline)> {
        let subject = Subject::at_home(name.clone());
        let site = subject.locate(&self.catalog, &mut Quiet)?;
        let (task, steps_per_hour) = (self.config.task()?, self.config.steps_per_hour);
        let episode = Episode { subject, task, period, seed: 0, steps_per_hour };
        let baseline = baselines.baseline(evaluation, &episode, &site, &())?;
        Ok((episode, baseline))
    }
}

/// The factors of rewards of drawn buildings: 1 over the mean penalty per step of the reactive controllers in the building, over
/// the days of an evaluation in the middle of the run period. An episode of them runs when a building is first drawn, and is kept in
/// the cache of baselines.
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
        let days = config.evaluation.days.max(1);
        let period = window(config.run_period()?, days);
        environments.scale_of(&spaces.building.name.parse()?, period, &evaluation, baselines)
    }
}

fn training_rows(building_type: BuildingType) -> impl Iterator<Item = b2b_dataset::BuildingId> {
    b2b_dataset::rows(building_type).iter().filter(|row| row.split == Split::Train).map(|row| row.id)
}
