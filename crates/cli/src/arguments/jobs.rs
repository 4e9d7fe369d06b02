//! The degree of parallelism.

use anyhow::Result;
use serde::Deserialize;

/// The number of buildings or episodes in progress at a time.
#[derive(clap::Args, Default, Deserialize)]
#[serde(transparent)]
pub struct Jobs {
    /// Number of buildings, episodes or jobs to process in parallel [default: number of CPU cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,
}

impl Jobs {
    /// Returns the number given, or the number of cores.
    pub fn count(&self) -> Result<usize> {
        Ok(match self.jobs {
            Some(jobs) => jobs as usize,
            None => std::thread::available_parallelism()?.get(),
        })
    }
}
