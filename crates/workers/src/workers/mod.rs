//! A shared set of worker processes.

pub(crate) mod launcher;
pub(crate) mod worker_options;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use b2b_energyplus::Library;

use self::worker_options::WorkerOptions;
use super::fragment::SharedMemory;
use super::pool::{Pool, TemplateId};
use super::region::{LOOK, Region};
use super::setting::EpisodeSetting;
use b2b_env::Spaces;
use b2b_env::{Error, Result};

/// A shared set of worker processes, in which episodes run.
///
/// 1. [`Workers::prepare`] sizes and warms up a building in its own process, the *template* of a setting.
/// 2. [`Workers::episode`] creates an episode of it; every reset is a copy of the template, within milliseconds.
/// 3. All processes end when the last handle and the last episode are dropped, and when this process dies.
///
/// Clones share the processes. Handles and episodes may move between threads, but are fastest in one thread; threads
/// that run episodes concurrently should each have their own set. A set belongs to the process that created it;
/// dropping it in a fork does nothing.
#[derive(Clone)]
pub struct Workers {
    shared: Arc<Shared>,
}

struct Shared {
    /// `None` only during drop.
    pool: Option<Mutex<Pool>>,
    region: Arc<Region>,
    /// Number of reserved values of shared memory.
    reserved: AtomicUsize,
    step_time_limit: Duration,
    interrupted: fn() -> bool,
    /// The process that it belongs to.
    owner: u32,
}

impl std::fmt::Debug for Workers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Workers({} templates)", self.template_processes().len())
    }
}

impl Workers {
    /// Creates a set without processes.
    ///
    /// # Errors
    /// [`Error::Pool`] without shared memory; [`Error::Io`] without a temporary folder.
    pub fn new(options: WorkerOptions) -> Result<Self> {
        let region = Region::new()
            .map_err(|source| Error::Pool { what: "memory to share with workers".into(), source })?;
        let region = Arc::new(region);
        let (step_time_limit, interrupted) = (options.step_time_limit, options.interrupted);
        let pool = Some(Mutex::new(Pool::new(options, Arc::clone(&region))?));
        let reserved = AtomicUsize::new(0);
        let owner = std::process::id();
        let shared = Shared { pool, region, reserved, step_time_limit, interrupted, owner };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Prepares a setting if necessary and returns its spaces.
    ///
    /// # Errors
    /// [`Error::Template`] with the reason when the building cannot be prepared; [`Error::Lost`] when its preparation
    /// died or hung twice; [`Error::Pool`]; [`Error::Interrupted`].
    pub fn prepare(&self, setting: &EpisodeSetting) -> Result<Arc<Spaces>> {
        loop {
            let done = self.region().done();
            if let Some(spaces) = self.try_prepare(setting)? {
                return Ok(spaces);
            }
            self.region().sleep(done, 1, LOOK);
            self.check_interrupt()?;
        }
    }

    /// Prepares several settings at the same time.
    ///
    /// # Errors
    /// Same as [`Workers::prepare`].
    pub fn prepare_all(&self, settings: &[EpisodeSetting]) -> Result<Vec<Arc<Spaces>>> {
        for setting in settings {
            self.start_preparing(setting)?;
        }
        settings.iter().map(|setting| self.prepare(setting)).collect()
    }

    /// Starts to prepare a setting if necessary, without waiting.
    pub(super) fn start_preparing(&self, setting: &EpisodeSetting) -> Result<()> {
        self.lock().template_of(setting).map(|_| ())
    }

    /// Returns the spaces of a prepared setting; otherwise starts to prepare it. Does not wait.
    pub(super) fn try_prepare(&self, setting: &EpisodeSetting) -> Result<Option<Arc<Spaces>>> {
        let mut pool = self.lock();
        let template = pool.template_of(setting)?;
        pool.spaces_of(template)
    }

    /// Starts to prepare a setting and keeps its template for a future episode. Does not wait.
    pub(super) fn reserve(&self, setting: &EpisodeSetting) -> Result<Reservation> {
        let template = self.lock().reserve(setting)?;
        Ok(Reservation { workers: self.clone(), template })
    }

    /// Returns the spaces of settings, from the cache of prepared buildings where possible; prepares the others.
    ///
    /// # Errors
    /// Same as [`Workers::prepare`].
    pub fn spaces(&self, settings: &[EpisodeSetting]) -> Result<Vec<Arc<Spaces>>> {
        let library = self.lock().options.library.clone();
        let library = Library::load(&library)?;
        let mut cached = Vec::with_capacity(settings.len());
        for EpisodeSetting { source, episode } in settings {
            episode.check()?;
            let building = source.cached(&library);
            cached.push(building.map(|building| Arc::new(Spaces::new(Arc::new(building), episode.clone()))));
        }
        for (setting, _) in settings.iter().zip(&cached).filter(|(_, cached)| cached.is_none()) {
            self.start_preparing(setting)?;
        }
        settings
            .iter()
            .zip(cached)
            .map(|(setting, cached)| cached.map_or_else(|| self.prepare(setting), Ok))
            .collect()
    }

    /// Reserves memory for `count` numbers shared by the processes, for the lifetime of the set, and returns their
    /// position.
    ///
    /// # Errors
    /// [`Error::Pool`] without enough memory.
    pub fn reserve_memory(&self, count: usize) -> Result<usize> {
        let place = self.shared.reserved.fetch_add(count, Ordering::Relaxed);
        let reserved = self.region().reserve_shared(place, count);
        reserved
            .map_err(|source| Error::Pool { what: format!("{count} numbers of shared memory"), source })?;
        Ok(place)
    }

    /// The memory shared by the processes.
    pub fn memory(&self) -> SharedMemory {
        SharedMemory::new(Arc::clone(&self.shared.region))
    }

    /// The processes of the templates.
    pub fn template_processes(&self) -> Vec<u32> {
        self.lock().template_processes()
    }

    /// The processes of the templates that are not ready yet.
    pub fn preparing_processes(&self) -> Vec<u32> {
        self.lock().preparing_processes()
    }

    /// The temporary folder for all files of the processes. Removed with the set.
    pub fn folder(&self) -> PathBuf {
        self.lock().folder().to_owned()
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Pool> {
        let pool = self.shared.pool.as_ref().expect("the pool is there until it is dropped");
        pool.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn region(&self) -> &Region {
        &self.shared.region
    }

    pub(super) fn step_time_limit(&self) -> Duration {
        self.shared.step_time_limit
    }

    pub(super) fn check_interrupt(&self) -> Result<()> {
        if (self.shared.interrupted)() { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// Returns whether both are the same set.
    pub(super) fn are(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared)
    }

    /// Returns whether this is its owner process and not a fork.
    pub(super) fn belong_to_this_process(&self) -> bool {
        self.shared.owner == std::process::id()
    }
}

/// A template that is kept for a future episode until dropped.
pub(super) struct Reservation {
    workers: Workers,
    template: TemplateId,
}

impl Reservation {
    /// Returns whether its preparation is over, with or without success.
    pub(super) fn is_prepared(&self) -> bool {
        self.workers.lock().is_prepared(self.template)
    }

    /// The spaces of the setting if it is prepared. Does not wait.
    pub(super) fn spaces(&self) -> Result<Option<Arc<Spaces>>> {
        self.workers.lock().spaces_of(self.template)
    }

    /// Returns whether both have the same template.
    pub(super) fn is(&self, other: &Self) -> bool {
        self.template == other.template
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        if self.workers.belong_to_this_process() {
            self.workers.lock().cancel(self.template);
        }
    }
}

impl Drop for Shared {
    /// A fork of the owner does not touch the workers and their files.
    fn drop(&mut self) {
        if self.owner != std::process::id() {
            std::mem::forget(self.pool.take());
        }
    }
}
