//! An episode in a worker process as an environment.

use std::sync::Arc;

use super::Episode;
use crate::batch::wait;
use b2b_env::Metrics;
use b2b_env::Result;
use b2b_env::Spaces;
use b2b_env::{Environment, Step};

impl Environment for Episode {
    fn spaces(&self) -> &Arc<Spaces> {
        self.known_spaces()
    }

    fn reset(&mut self) -> Result<&[f64]> {
        self.begin()?;
        wait(std::slice::from_mut(self), 1)?;
        Ok(self.last_step()?.observation)
    }

    fn step(&mut self, action: &[f64]) -> Result<Step<'_>> {
        self.send(action)?;
        wait(std::slice::from_mut(self), 1)?;
        self.last_step()
    }

    fn metrics(&self) -> Option<&Metrics> {
        self.known_metrics()
    }
}
