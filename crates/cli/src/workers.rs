//! Environments in worker processes, which are this program started once more.

use std::path::Path;
use std::sync::Arc;

use b2b_env::EpisodeConfig;
use b2b_env::vector::{Autoreset, Launcher, PoolOptions, Setting, Source, VecEnvOptions};

use crate::interrupt;
use crate::prepare::Prepared;

/// Returns how workers with this engine are started. Waiting for them ends with an interrupt.
pub fn pool_options(engine: &Path) -> std::io::Result<PoolOptions> {
    let options = PoolOptions::new(Launcher::this_program()?, engine);
    Ok(PoolOptions { interrupted: interrupt::requested, ..options })
}

impl Prepared {
    /// Returns how workers of this building are started.
    pub fn pool_options(&self) -> anyhow::Result<PoolOptions> {
        Ok(pool_options(self.library.path())?)
    }

    /// Returns the same for a batch of environments.
    pub fn vec_env_options(&self) -> anyhow::Result<VecEnvOptions> {
        Ok(VecEnvOptions { pool: self.pool_options()?, autoreset: Autoreset::NextStep, widths: None })
    }

    /// Returns the building as the setting of an episode.
    pub fn setting(&self, episode: EpisodeConfig) -> Setting {
        Setting { source: Arc::new(Source::Prepared(Box::new((*self.building).clone()))), episode }
    }
}
