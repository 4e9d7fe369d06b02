//! The training environments of a configuration.

use std::sync::Arc;

use b2b_base::spread::spread;
use b2b_building::{BuildingType, Period};
use b2b_dataset::{BuildingName, Catalog};
use b2b_energyplus::install::Quiet;
use b2b_env::{EpisodeConfig, Spaces, Task};
use b2b_workers::{
    Autoreset, Buildings, EpisodeSetting, Kept, Population, Rotating, RoundRobin, Sampler, Source, VecEnv,
    VecEnvOptions, Weighted, Windows, WithFaults, WithTask, WorkerOptions,
};

use super::days;
use super::paired::Paired;
use super::staggered::Staggered;
use crate::credit::credit;
use crate::error::Result;
use crate::fragments::{FragmentCollector, GraphBuilding, RewardScale};
use crate::learner::{Learner, LearnerSetting};
use crate::limits::require;
use crate::lockstep::LockstepCollector;
use crate::train::config::{TrainConfig, TrainingSet};
use crate::widths::Widths;

/// A building with a task in a run period.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Evaluated {
    pub(crate) name: BuildingName,
    pub(crate) task: Task,
    /// The whole run period.
    pub(crate) period: Period,
}

/// Makes the environments of a configuration.
pub(crate) struct Environments<'a> {
    pub(super) config: &'a TrainConfig,
    pub(super) catalog: Arc<Catalog>,
}

impl<'a> Environments<'a> {
    pub(crate) fn new(config: &'a TrainConfig, catalog: Arc<Catalog>) -> Self {
        Self { config, catalog }
    }

    /// Returns the batch of training environments, before its first reset.
    fn vector(&self, workers: WorkerOptions) -> Result<VecEnv> {
        let options = VecEnvOptions { workers, autoreset: Autoreset::Disabled, widths: None };
        Ok(VecEnv::new(self.config.budget.environments, self.sampler()?, options)?)
    }

    /// Returns a collector of fragments in the batch, with the first episodes begun.
    pub(crate) fn fragments(&self, workers: WorkerOptions, scale: RewardScale) -> Result<FragmentCollector> {
        let Self { config, .. } = self;
        let mut collector = FragmentCollector::new(
            self.vector(workers)?,
            config.agent.interface(),
            config.rewards.credit_by_zone,
            config.noise.noise_correlation,
            config.rewards.travel_cost,
            scale,
            config.budget.seed,
        )?;
        collector =
            collector.with_discount(config.learner.discount()).with_memory_episodes(self.memory_episodes());
        self.room()?.into_iter().for_each(|widths| collector.make_room(widths));
        Ok(match config.noise.mirrored_noise {
            true => collector.with_mirrored_noise(),
            false => collector,
        })
    }

    /// Returns the widths of one building of every shape that may be drawn, for graph networks.
    fn room(&self) -> Result<Vec<Widths>> {
        let interface = self.config.agent.interface();
        if interface.nodes.is_none() {
            return Ok(Vec::new());
        }
        let mut all = Vec::new();
        for building_type in self.config.training_set.building_types()? {
            let buildings = self.population(building_type, self.config.training_set.periods()?[0]);
            for (name, building) in buildings.population.representatives()? {
                let setting = buildings.setting(name, &building)?;
                let prepared = Arc::unwrap_or_clone(setting.source).prepare(self.catalog.library())?;
                let spaces = Arc::new(Spaces::new(Arc::new(prepared), setting.episode));
                let building = GraphBuilding::of(interface, self.config.rewards.credit_by_zone, &spaces)?;
                all.extend(building.map(|building| building.widths()));
            }
        }
        Ok(all)
    }

    fn population(&self, building_type: BuildingType, period: Period) -> Buildings {
        Buildings {
            catalog: Arc::clone(&self.catalog),
            population: Population::Ids(self.config.training_set.drawn(building_type)),
            control: self.config.training_set.control,
            period,
            steps_per_hour: self.config.training_set.steps_per_hour,
            task: self.config.training_set.task.as_slice()[0].clone(),
        }
    }

    /// Returns a collector in lockstep in the batch, with the first episodes begun.
    pub(crate) fn lockstep(&self, workers: WorkerOptions, scale: RewardScale) -> Result<LockstepCollector> {
        let Self { config, .. } = self;
        for (name, is_used, none) in [
            ("credit_by_zone", config.rewards.credit_by_zone, "false"),
            ("travel_cost", config.rewards.travel_cost > 0.0, "0"),
            ("mirrored_noise", config.noise.mirrored_noise, "false"),
        ] {
            require(!is_used, || {
                format!("`{name}` requires the loop design fragments; in lockstep it must be {none}")
            })?;
        }
        require(config.hold() == 1, || "held decisions require the loop design fragments".into())?;
        let collector = LockstepCollector::new(
            self.vector(workers)?,
            config.agent.interface(),
            config.noise.noise_correlation,
            scale,
            config.budget.seed,
        )?;
        Ok(collector.with_memory_episodes(self.memory_episodes()))
    }

    /// Returns the episodes in a building that the memory of a recurrent actor spans.
    fn memory_episodes(&self) -> u32 {
        self.config.agent.policy.recurrent().map_or(1, |policy| policy.memory_episodes)
    }

    /// Checks that the episodes of a memory are in one building.
    ///
    /// # Errors
    /// [`Error::Invalid`](crate::Error::Invalid) with the remedy where they may not be.
    pub(crate) fn check_memory(&self) -> Result<()> {
        let (set, episodes) = (&self.config.training_set, self.memory_episodes());
        let found = || format!("`policy.memory_episodes` is {episodes}");
        if episodes == 1 {
            return Ok(());
        }
        if set.building_types()?.is_empty() {
            let (named, environments) = (set.buildings.len(), self.config.distinct_environments());
            require(named <= environments, || {
                let expected = "an environment for every building (pairs count as one)";
                format!(
                    "{} and {named} buildings share {environments} environments; expected {expected}",
                    found()
                )
            })?;
            // An environment keeps its building; only faults may change.
            if set.fault_seeds == 0 {
                return Ok(());
            }
        }
        let kept = set.building_episodes;
        require(kept.is_multiple_of(episodes), || {
            format!("{} and `building_episodes` is {kept}; expected a multiple of it", found())
        })?;
        let mut parts = 0;
        for period in set.periods()? {
            parts += days::trained(self.config, period).len();
        }
        require(parts == 1, || {
            format!(
                "{}, but the days of training have {parts} parts, each with its own buildings; choose one run period and \
                 `evaluation.held_out` = false",
                found()
            )
        })
    }

    /// Returns the sampler of training episodes.
    fn sampler(&self) -> Result<Box<dyn Sampler>> {
        let one = || self.sampler_for(self.config.distinct_environments());
        Ok(match self.config.noise.mirrored_noise {
            true => Box::new(Paired::new([one()?, one()?], self.config.budget.seed)),
            false => one()?,
        })
    }

    /// Returns the sampler for a number of environments: windows of some days in each part of a run period that is
    /// used for training, with equal shares of the run periods.
    fn sampler_for(&self, environments: usize) -> Result<Box<dyn Sampler>> {
        let settings = self.settings()?;
        let mut samplers = Vec::new();
        for period in self.config.training_set.periods()? {
            let parts = days::trained(self.config, period);
            let all: u32 = parts.iter().map(|part| part.days()).sum();
            for part in parts {
                let starts = (self.config.training_set.window_starts * part.days()).div_ceil(all);
                samplers.push((f64::from(starts), self.part(part, starts, &settings, environments)?));
            }
        }
        let all: Box<dyn Sampler> = match samplers.len() {
            1 => samplers.remove(0).1,
            _ => Box::new(Weighted::new(samplers)?),
        };
        let (learner, day) = (&self.config.learner, 24 * self.config.training_set.steps_per_hour as usize);
        let hold = self.config.hold();
        let steps = learner.steps_per_rollout() * hold;
        Ok(match learner.is_on_policy() && !steps.is_multiple_of(day) {
            true => Box::new(Staggered::new(all, environments, hold)),
            false => all,
        })
    }

    /// Returns the sampler of windows that begin on a number of days of a part of the run period.
    fn part(
        &self,
        part: Period,
        starts: u32,
        settings: &[EpisodeSetting],
        environments: usize,
    ) -> Result<Box<dyn Sampler>> {
        let buildings = self.buildings(part, settings, environments)?;
        let buildings = match self.config.training_set.task.as_slice() {
            [_] => buildings,
            tasks => Box::new(WithTask { of: buildings, tasks: tasks.to_vec() }),
        };
        let TrainingSet { fault_seeds, building_episodes, .. } = self.config.training_set;
        let buildings = match fault_seeds {
            0 => buildings,
            seeds => Box::new(WithFaults::new(buildings, seeds, building_episodes)),
        };
        let days = self.config.training_set.window_days;
        if days == 0 {
            return Ok(buildings);
        }
        Ok(Box::new(Windows { of: buildings, days: (days, days), starts }))
    }

    /// Returns the sampler of the buildings over all days of a part of a run period.
    fn buildings(
        &self,
        period: Period,
        settings: &[EpisodeSetting],
        environments: usize,
    ) -> Result<Box<dyn Sampler>> {
        let types = self.config.training_set.turns()?;
        if !types.is_empty() {
            let of_type = |building_type: &BuildingType| -> Result<Box<dyn Sampler>> {
                Ok(Box::new(self.population(*building_type, period)))
            };
            let all = RoundRobin(types.iter().map(of_type).collect::<Result<_>>()?);
            return Ok(Box::new(Kept::new(all, self.config.training_set.building_episodes)));
        }
        let mut settings = settings.to_vec();
        for EpisodeSetting { episode, .. } in &mut settings {
            episode.period = period.in_weather(&episode.weather).map_err(b2b_env::Error::building)?;
        }
        Ok(Box::new(Rotating::new(settings, environments)))
    }

    /// Returns the settings of the buildings that are named, over the whole first run period.
    fn settings(&self) -> Result<Vec<EpisodeSetting>> {
        let (periods, steps_per_hour) =
            (self.config.training_set.periods()?, self.config.training_set.steps_per_hour);
        let (task, placement) =
            (&self.config.training_set.task.as_slice()[0], self.config.training_set.placement()?);
        let setting = |name: &BuildingName| {
            let found = self.catalog.find(name, &placement, &mut Quiet)?;
            let weather = found.weather.clone();
            let period = periods[0].in_weather(&weather).map_err(b2b_env::Error::building)?;
            let episode = EpisodeConfig { weather, period, steps_per_hour, task: task.clone() };
            Ok(EpisodeSetting::new(Source::from(found), episode))
        };
        self.config.training_set.named()?.iter().map(setting).collect()
    }

    /// Returns the evaluations during training: evenly spread training buildings, at least as many as there are types, each
    /// with every task in every run period.
    pub(crate) fn evaluated(&self) -> Result<Vec<Evaluated>> {
        let types = self.config.training_set.building_types()?;
        let all: Vec<BuildingName> = match &types[..] {
            [] => self.config.training_set.named()?,
            types => types
                .iter()
                .flat_map(|each| self.config.training_set.drawn(*each))
                .map(BuildingName::Id)
                .collect(),
        };
        // Every type, so that comfort is held in each.
        self.in_every_way(spread(&all, self.config.evaluation.buildings.max(types.len()).max(1)))
    }

    /// Returns buildings with every task in every run period.
    pub(super) fn in_every_way(&self, names: Vec<BuildingName>) -> Result<Vec<Evaluated>> {
        let TrainingSet { task, .. } = &self.config.training_set;
        let mut all = Vec::new();
        for period in self.config.training_set.periods()? {
            for name in &names {
                let with = |task: &Task| Evaluated { name: name.clone(), task: task.clone(), period };
                all.extend(task.as_slice().iter().map(with));
            }
        }
        Ok(all)
    }
}

/// Returns the learner of a configuration, for buildings with these spaces.
pub(crate) fn learner(config: &TrainConfig, widths: Widths, spaces: &Spaces) -> Result<Box<dyn Learner>> {
    config.learner.learner(&LearnerSetting {
        widths,
        environments: config.budget.environments,
        interface: config.agent.interface(),
        policy: &config.agent.policy,
        credit: config.rewards.credit_by_zone.then(|| credit(spaces, &config.agent.acting.owners(spaces))),
        hold: config.hold(),
        seed: config.budget.seed,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
    })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    #[test]
    fn named_buildings_beyond_the_number_of_environments_are_trained_on_too() {
        let catalog = Arc::new(Catalog::open(&mut Quiet).unwrap());
        let names: Vec<String> = (1..=5).map(|number| format!("SingleFamilyHouse-{number:04}")).collect();
        for (environments, mirrored_noise) in [(2, false), (4, true)] {
            let mut config = TrainConfig::default();
            config.training_set.buildings.clone_from(&names);
            (config.budget.environments, config.noise.mirrored_noise) = (environments, mirrored_noise);
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
    fn the_episodes_of_a_memory_are_in_one_building() {
        let catalog = Arc::new(Catalog::open(&mut Quiet).unwrap());
        let check_policy = |policy: &str, options: &str| {
            let options = format!(
                "policy = {{ kind = {policy}, memory_episodes = 3 }}\nwindow_days = 7\nppo = {{ n_steps = 288 }}\n{options}"
            );
            let config = TrainConfig::default().with_changes(&options).unwrap();
            config.check().unwrap();
            let environments = Environments::new(&config, Arc::clone(&catalog));
            environments.check_memory().map(|()| {
                let mut sampler = environments.sampler().unwrap();
                let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(0);
                let mut drawn = || sampler.draw(1, &mut random).unwrap().setting.source.name().to_owned();
                let names: Vec<String> = (0..9).map(|_| drawn()).collect();
                assert!(
                    names.chunks(3).all(|memory| memory.iter().all(|name| *name == memory[0])),
                    "{names:?}"
                );
            })
        };
        let check = |options: &str| check_policy("'recurrent'", options);
        let said = |options: &str| check(options).unwrap_err().to_string();
        let two = "buildings = ['OfficeSmall-0001', 'OfficeSmall-0002']\nenvironments";
        check(&format!("{two} = 2")).unwrap();
        assert!(said(&format!("{two} = 1")).contains("2 buildings share 1 environments"));
        let wrong = said(&format!("{two} = 2\ntask = 'constant+bias1'\nfault_seeds = 8"));
        assert!(wrong.contains("`building_episodes` is 1; expected a multiple of it"), "{wrong}");
        let any = "building_type = 'OfficeSmall'\nbuilding_episodes";
        check(&format!("{any} = 6\nevaluation.held_out = false")).unwrap();
        let wrong = said(&format!("{any} = 4\nevaluation.held_out = false"));
        assert!(wrong.contains("`building_episodes` is 4; expected a multiple of it"), "{wrong}");
        let wrong = said(&format!("{any} = 3"));
        assert!(wrong.contains("have 2 parts") && wrong.contains("`evaluation.held_out` = false"), "{wrong}");
        let types = "building_type = ['OfficeSmall', 'Warehouse']\nbuilding_episodes = 3\nevaluation.held_out = false";
        check_policy("'graph', memory = 8", types).unwrap();
    }

    #[test]
    fn no_training_episode_has_a_day_of_the_evaluations() {
        let catalog = Arc::new(Catalog::open(&mut Quiet).unwrap());
        // Rollouts of whole days: all episodes are whole windows.
        let of = |buildings: &str| {
            let options =
                format!("{buildings}\nwindow_days = 14\nwindow_starts = 6\nppo = {{ n_steps = 288 }}");
            TrainConfig::default().with_changes(&options).unwrap()
        };
        for buildings in ["buildings = ['OfficeSmall-0042']", "building_type = 'OfficeSmall'"] {
            let config = of(buildings);
            let day = |date: b2b_building::Date| date.day_of_year();
            let [winter] = config.training_set.periods().unwrap()[..] else { panic!("one period") };
            let Period::Days(held_out) = days::evaluated(&config, winter) else { panic!("days") };
            let mut sampler = Environments::new(&config, Arc::clone(&catalog)).sampler().unwrap();
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(0);
            let mut first_days: Vec<u32> = Vec::new();
            for _ in 0..40 {
                let draw = sampler.draw(0, &mut random).unwrap();
                let period = draw.setting.episode.period;
                assert_eq!((period.days(), draw.steps), (14, Some(14 * 288)));
                assert!(!period.overlaps(held_out), "{period} has days of {held_out}");
                first_days.push(day(period.first()));
            }
            first_days.sort_unstable();
            first_days.dedup();
            assert_eq!(first_days, [1, 13, 25, 53, 65, 77], "six first days");
        }
    }
}
