//! Environments in worker processes, which are this program started once more.

use std::path::Path;

use b2b_env::EpisodeConfig;
use b2b_env::vector::{Autoreset, Launcher, Setting, Source, VecEnvOptions, WorkerOptions};

use crate::interrupt;
use crate::prepare::Prepared;

/// Returns how workers with this engine are started. Waiting for them ends with an interrupt.
pub fn worker_options(engine: &Path) -> std::io::Result<WorkerOptions> {
    let options = WorkerOptions::new(Launcher::this_program()?, engine);
    Ok(WorkerOptions { interrupted: interrupt::requested, ..options })
}

impl Prepared {
    /// Returns how workers of this building are started.
    pub fn worker_options(&self) -> anyhow::Result<WorkerOptions> {
        Ok(worker_options(self.library.path())?)
    }

    /// Returns the same for a batch of environments.
    pub fn vec_env_options(&self) -> anyhow::Result<VecEnvOptions> {
        Ok(VecEnvOptions { workers: self.worker_options()?, autoreset: Autoreset::NextStep, widths: None })
    }

    /// Returns the building as the setting of an episode.
    pub fn setting(&self, episode: EpisodeConfig) -> Setting {
        Setting::new(Source::Prepared(Box::new((*self.building).clone())), episode)
    }
}
