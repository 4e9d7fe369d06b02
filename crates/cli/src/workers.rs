//! Environments in worker processes, which are this program started once more.

use std::path::Path;

use b2b_env::EpisodeConfig;
use b2b_env::vector::{Autoreset, Setting, Source, VecEnvOptions, WorkerOptions};

use crate::prepare::Prepared;
use crate::{interrupt, program};

/// Returns how workers with this engine are started. Waiting for them ends with an interrupt.
pub fn worker_options(engine: &Path) -> WorkerOptions {
    let options = WorkerOptions::new(program::launcher(), engine);
    WorkerOptions { interrupted: interrupt::requested, ..options }
}

impl Prepared {
    /// Returns how workers of this building are started.
    pub fn worker_options(&self) -> WorkerOptions {
        worker_options(self.library.path())
    }

    /// Returns the same for a batch of environments.
    pub fn vec_env_options(&self) -> VecEnvOptions {
        VecEnvOptions { workers: self.worker_options(), autoreset: Autoreset::NextStep, widths: None }
    }

    /// Returns the building as the setting of an episode.
    pub fn setting(&self, episode: EpisodeConfig) -> Setting {
        Setting::new(Source::Prepared(Box::new((*self.building).clone())), episode)
    }
}
