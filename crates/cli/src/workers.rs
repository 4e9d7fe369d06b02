//! Environments in worker processes, which run this program.

use std::path::Path;

use b2b_env::EpisodeConfig;
use b2b_workers::{Autoreset, Setting, Source, VecEnvOptions, WorkerOptions};

use crate::prepare::Prepared;
use crate::{interrupt, program};

/// Returns the options of workers with this engine. An interrupt ends any wait for them.
pub fn worker_options(engine: &Path) -> WorkerOptions {
    let options = WorkerOptions::new(program::launcher(), engine);
    WorkerOptions { interrupted: interrupt::requested, ..options }
}

impl Prepared {
    /// Returns the options of workers with this building's engine.
    pub fn worker_options(&self) -> WorkerOptions {
        worker_options(self.library.path())
    }

    /// Returns the options of a batch of environments.
    pub fn vec_env_options(&self) -> VecEnvOptions {
        VecEnvOptions { workers: self.worker_options(), autoreset: Autoreset::NextStep, widths: None }
    }

    /// Returns the setting of an episode in this building.
    pub fn setting(&self, episode: EpisodeConfig) -> Setting {
        Setting::new(Source::Prepared(Box::new((*self.building).clone())), episode)
    }
}
