//! The processes in which a thread runs the episodes of a building.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use b2b_building::{Controls, PreparedBuilding};
use b2b_dataset::Catalog;
use b2b_energyplus::install::Quiet;
use b2b_env::Inputs;
use b2b_workers::{EpisodeSetting, RolloutMemory, Source, WorkerOptions, Workers};

use super::episode::EpisodePlan;
use super::parallel::Evaluation;
use super::progress::Progress;
use super::sequence::sequences;
use crate::Result;
use crate::policy::Policy;
use crate::subject::{SiteInfo, Subject};

/// The episodes of one building that wait to be run, by [sequence](sequences).
pub(super) struct BuildingGroup<'a> {
    subject: &'a Subject,
    waiting: Mutex<VecDeque<Vec<usize>>>,
    located: Mutex<Option<Arc<Located>>>,
    /// Set once a thread has prepared the building, so that the others need not.
    prepared: OnceLock<Arc<PreparedBuilding>>,
}

/// A building with its place.
#[derive(Debug)]
pub(super) struct Located {
    pub(super) subject: Subject,
    pub(super) site: SiteInfo,
    weather: PathBuf,
    source: Arc<Source>,
}

/// A pool of processes with a building.
pub(super) struct Bench {
    pub(super) workers: Workers,
    /// Memory for the records of its episodes.
    pub(super) memory: RolloutMemory,
    pub(super) located: Arc<Located>,
    /// Source of its episodes, which share its preparation.
    source: Arc<Source>,
    /// The building as prepared by the first episode.
    pub(super) prepared: Option<Arc<PreparedBuilding>>,
    /// Inputs of its first episode, which are the same for all.
    pub(super) inputs: Option<Inputs>,
}

impl<'a> BuildingGroup<'a> {
    /// Groups episodes in list order: consecutive episodes in the same building form a group.
    pub(super) fn of(episodes: &[(usize, &'a EpisodePlan)], policy: &dyn Policy) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for sequence in sequences(episodes.iter().map(|(_, episode)| *episode), policy) {
            let subject = &episodes[sequence[0]].1.subject;
            match groups.last_mut() {
                Some(group) if group.subject == subject => lock(&group.waiting).push_back(sequence),
                _ => groups.push(Self {
                    subject,
                    waiting: Mutex::new(VecDeque::from([sequence])),
                    located: Mutex::default(),
                    prepared: OnceLock::new(),
                }),
            }
        }
        groups
    }

    /// Takes a sequence that has not been started, and returns the positions of its episodes.
    pub(super) fn take(&self) -> Option<Vec<usize>> {
        lock(&self.waiting).pop_front()
    }

    /// Publishes the prepared building.
    pub(super) fn is_prepared(&self, bench: &Bench) {
        if let Some(building) = &bench.prepared {
            self.prepared.get_or_init(|| Arc::clone(building));
        }
    }

    /// Returns the building, which the first caller finds.
    fn located(
        &self,
        catalog: &Catalog,
        controls: Controls,
        progress: &dyn Progress,
    ) -> Result<Arc<Located>> {
        let mut located = lock(&self.located);
        if let Some(located) = &*located {
            return Ok(Arc::clone(located));
        }
        let subject = self.subject.clone();
        let found = catalog.find(&subject.name, &subject.placement, &mut Quiet)?;
        let building = subject.name.to_string();
        found.notes.lines().for_each(|note| progress.note(&building, &note));
        let site = subject.site(&found)?;
        let weather = found.weather.clone();
        let source = Source::from(found.under(controls));
        let made = Arc::new(Located { subject, site, weather, source: Arc::new(source) });
        *located = Some(Arc::clone(&made));
        Ok(made)
    }
}

impl Bench {
    /// Creates a pool for the remaining episodes of a building.
    pub(super) fn new(
        evaluation: &Evaluation<'_>,
        controls: Controls,
        group: &BuildingGroup<'_>,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let located = group.located(evaluation.catalog, controls, progress)?;
        let source = match group.prepared.get() {
            Some(building) => Arc::new(Source::Prepared(Box::new(PreparedBuilding::clone(building)))),
            None => Arc::clone(&located.source),
        };
        let options = WorkerOptions {
            interrupted: evaluation.interrupted,
            // A template serves its episodes one after another, and goes when the next is made.
            template_memory: 0,
            ..WorkerOptions::new(evaluation.launcher.clone(), evaluation.catalog.library().path())
        };
        let workers = Workers::new(options)?;
        Ok(Self {
            memory: RolloutMemory::new(&workers),
            workers,
            located,
            source,
            prepared: None,
            inputs: None,
        })
    }

    /// An episode of the building.
    pub(super) fn setting(&self, episode: &EpisodePlan) -> Result<EpisodeSetting> {
        let episode = b2b_env::EpisodeConfig {
            weather: self.located.weather.clone(),
            period: episode.period.in_weather(&self.located.weather).map_err(b2b_env::Error::building)?,
            steps_per_hour: episode.steps_per_hour,
            task: episode.task.clone(),
        };
        Ok(EpisodeSetting { source: Arc::clone(&self.source), episode })
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
