//! Environments in processes of their own, which are this program started once more.

use std::sync::Arc;

use anyhow::Result;
use b2b_env::EpisodeConfig;
use b2b_env::vector::{Autoreset, Launcher, PoolOptions, Setting, Source, VecEnvOptions};

use crate::interrupt;
use crate::prepare::Prepared;

impl Prepared {
    /// How processes of this building are started. Waiting for them ends with an interrupt.
    pub fn pool_options(&self) -> Result<PoolOptions> {
        let options = PoolOptions::new(Launcher::this_program()?, self.library.path());
        Ok(PoolOptions { interrupted: interrupt::requested, ..options })
    }

    /// The same for many at once.
    pub fn vec_env_options(&self) -> Result<VecEnvOptions> {
        Ok(VecEnvOptions { pool: self.pool_options()?, autoreset: Autoreset::NextStep, widths: None })
    }

    /// The building as the setting of an episode.
    pub fn setting(&self, episode: EpisodeConfig) -> Setting {
        Setting { source: Arc::new(Source::Prepared(Box::new((*self.building).clone()))), episode }
    }
}
