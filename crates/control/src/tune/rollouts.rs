//! Repeated episodes of the same buildings under different controllers.

use std::ops::Range;
use std::sync::Arc;

use b2b_building::RunPeriod;
use b2b_dataset::{BuildingId, Catalog};
use b2b_energyplus::install::Progress;
use b2b_env::{Environment, EpisodeConfig, Metrics, Task};
use b2b_workers::{Episode, EpisodeSetting, Source, WorkerOptions, Workers, recv};

use crate::{Error, Reactive, ReactiveParameters, Result};

const STEPS_PER_HOUR: u32 = 12;

/// Buildings whose templates stay alive, so that an episode begins within milliseconds.
#[derive(Debug)]
pub struct Rollouts {
    workers: Workers,
    /// Settings of each building, one per task and period.
    settings: Vec<Vec<EpisodeSetting>>,
    /// Number of periods.
    periods: usize,
}

impl Rollouts {
    /// Prepares buildings of the dataset for some periods and tasks.
    ///
    /// # Errors
    /// [`Error::Building`] when a model cannot be generated, [`Error::Env`] when it cannot be prepared.
    pub fn new(
        options: WorkerOptions,
        catalog: &Catalog,
        buildings: &[BuildingId],
        periods: &[RunPeriod],
        tasks: &[Task],
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        let mut settings = Vec::new();
        for id in buildings {
            let building = &b2b_dataset::row(*id).building;
            let (model, weather) = catalog.generate(building, progress)?;
            let source = Source::generated(id.to_string(), building.class(), model, weather.clone());
            let source = Arc::new(source);
            let setting = |task: &Task, period: RunPeriod| {
                let (weather, task) = (weather.clone(), task.clone());
                let episode = EpisodeConfig { weather, period, steps_per_hour: STEPS_PER_HOUR, task };
                EpisodeSetting { source: Arc::clone(&source), episode }
            };
            let of_task = |task| periods.iter().map(move |period| (task, *period));
            let episodes = tasks.iter().flat_map(of_task);
            settings.push(episodes.map(|(task, period)| setting(task, period)).collect::<Vec<_>>());
        }
        let workers = Workers::new(options)?;
        // The first episode of a building sizes it for all.
        for episode in 0..periods.len() * tasks.len() {
            let ones: Vec<EpisodeSetting> =
                settings.iter().map(|settings| settings[episode].clone()).collect();
            workers.prepare_all(&ones)?;
        }
        Ok(Self { workers, settings, periods: periods.len() })
    }

    /// Runs episodes of a building under the reactive controllers with some parameters, one per period for each of a
    /// range of tasks. Building and tasks are given by their indices.
    ///
    /// # Errors
    /// [`Error::Lost`] when an episode is lost; [`Error::Env`].
    pub fn run(
        &mut self,
        parameters: &ReactiveParameters,
        building: usize,
        tasks: Range<usize>,
    ) -> Result<Vec<Metrics>> {
        let controller = Reactive::description(parameters);
        let mut episodes = Vec::new();
        for setting in &self.settings[building][tasks.start * self.periods..tasks.end * self.periods] {
            let mut episode = self.workers.episode(setting)?;
            episode.begin()?;
            episodes.push(episode);
        }
        wait_for(&mut episodes)?;
        episodes.iter_mut().try_for_each(|episode| episode.send_rollout(&controller))?;
        wait_for(&mut episodes)?;
        Ok(episodes.iter().filter_map(|episode| episode.metrics().cloned()).collect())
    }
}

/// Waits until no episode is busy.
fn wait_for(episodes: &mut [Episode]) -> Result<()> {
    recv(episodes, episodes.len(), &mut Vec::new())?;
    match episodes.iter().find_map(|episode| Some((episode, episode.lost()?))) {
        Some((episode, why)) => {
            Err(Error::Lost { building: episode.setting().source.name().to_owned(), why: why.to_owned() })
        }
        None => Ok(()),
    }
}
