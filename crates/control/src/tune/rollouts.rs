//! Episodes of some buildings, again and again, each under another controller.

use std::sync::Arc;

use b2b_building::RunPeriod;
use b2b_dataset::{BuildingId, Catalog};
use b2b_energyplus::install::Progress;
use b2b_env::vector::{Live, Pool, PoolOptions, Setting, Source, Start};
use b2b_env::{EpisodeConfig, Metrics, Task};

use crate::{Controller, Error, Reactive, ReactiveParameters, Result};

const STEPS_PER_HOUR: u32 = 12;

/// Buildings whose templates stay alive, so that an episode begins within milliseconds.
#[derive(Debug)]
pub struct Rollouts {
    pool: Pool,
    /// The settings of each building, for each task one for each period.
    settings: Vec<Vec<Setting>>,
}

/// An episode in progress and who acts in it.
struct Run {
    building: String,
    controller: Reactive,
    observation: Vec<f64>,
    action: Vec<f64>,
    metrics: Option<Metrics>,
}

impl Rollouts {
    /// Prepares buildings of the dataset for some periods and tasks.
    ///
    /// # Errors
    /// [`Error::Building`] when a model cannot be made, [`Error::Env`] when it cannot be prepared.
    pub fn new(
        options: PoolOptions,
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
            let source = Arc::new(Source::generated(id.to_string(), building.class(), model));
            let setting = |task: &Task, period: RunPeriod| {
                let (weather, task) = (weather.clone(), task.clone());
                let episode = EpisodeConfig { weather, period, steps_per_hour: STEPS_PER_HOUR, task };
                Setting { source: Arc::clone(&source), episode }
            };
            let of_task = |task| periods.iter().map(move |period| (task, *period));
            let episodes = tasks.iter().flat_map(of_task);
            settings.push(episodes.map(|(task, period)| setting(task, period)).collect::<Vec<_>>());
        }
        let mut pool = Pool::new(options)?;
        // The first episode of a building sizes it for all.
        for episode in 0..periods.len() * tasks.len() {
            let templates: Vec<_> = settings
                .iter()
                .map(|settings| pool.prepare(&settings[episode]))
                .collect::<b2b_env::Result<_>>()?;
            for template in templates {
                pool.spaces(template)?;
            }
        }
        Ok(Self { pool, settings })
    }

    /// The episodes of each building under the reactive controllers with some parameters: for each task one for each
    /// period.
    ///
    /// # Errors
    /// [`Error::Lost`] when an episode is lost; [`Error::Env`].
    pub fn run(&mut self, parameters: &ReactiveParameters) -> Result<Vec<Vec<Metrics>>> {
        let (mut lives, mut runs) = self.begin(parameters)?;
        let outcome = self.finish(&mut lives, &mut runs);
        lives.into_iter().for_each(|live| self.pool.stop(live));
        outcome?;
        let mut metrics = runs.into_iter().filter_map(|run| run.metrics);
        Ok(self.settings.iter().map(|settings| metrics.by_ref().take(settings.len()).collect()).collect())
    }

    fn begin(&mut self, parameters: &ReactiveParameters) -> Result<(Vec<Live>, Vec<Run>)> {
        let (mut lives, mut runs) = (Vec::new(), Vec::new());
        for settings in &self.settings {
            for setting in settings {
                let template = self.pool.prepare(setting)?;
                let live = self.pool.begin(template, Start::default())?;
                let spaces = live.spaces();
                let controller =
                    Reactive::new(&spaces.building, &spaces.observation, STEPS_PER_HOUR, parameters);
                runs.push(Run {
                    building: setting.source.name().to_owned(),
                    controller,
                    observation: vec![0.0; spaces.observation.len()],
                    action: vec![0.0; spaces.action.len()],
                    metrics: None,
                });
                lives.push(live);
            }
        }
        Ok((lives, runs))
    }

    fn finish(&mut self, lives: &mut [Live], runs: &mut [Run]) -> Result<()> {
        let mut done = 0;
        while done < lives.len() {
            // Half of them are enough to go on with: the others keep the processors busy meanwhile.
            self.pool.wait(lives, done + (lives.len() - done).div_ceil(2))?;
            for (live, run) in lives.iter_mut().zip(runs.iter_mut()) {
                if let Some(why) = live.lost() {
                    return Err(Error::Lost { building: run.building.clone(), why: why.to_owned() });
                }
                if live.is_busy() || run.metrics.is_some() {
                    continue;
                }
                if live.is_truncated() {
                    let gone =
                        || Error::Lost { building: run.building.clone(), why: "it left no sums".into() };
                    run.metrics = Some(self.pool.metrics(live).ok_or_else(gone)?);
                    done += 1;
                    continue;
                }
                self.pool.observation(live, &mut run.observation);
                run.controller.act(&run.observation, &mut run.action);
                self.pool.send(live, &run.action)?;
            }
        }
        Ok(())
    }
}
