//! Fragments: many steps in a row inside a worker, without its owner.
//!
//! The hand-over of every single step costs more than the step of a small building. A program that has a policy of its own, as a
//! learner has, gives its workers a [`Runner`] instead ([`run_if_worker_with`](super::run_if_worker_with)), orders
//! fragments ([`VecEnv::send_fragment`](super::VecEnv::send_fragment)) and reads what the runners leave in
//! [`SharedMemory`].

use std::fmt;
use std::sync::Arc;

use super::region::Region;
use crate::Env;

/// What went wrong in a runner; its text ends the episode as lost.
pub type RunnerError = Box<dyn std::error::Error>;

/// Runs fragments of one episode inside its worker process.
pub trait Runner {
    /// Carries out an order: any number of steps of the episode. Returns how many it made. Does not step an episode beyond its
    /// end.
    ///
    /// # Errors
    /// Any error ends the episode, which is lost.
    fn run(&mut self, env: &mut Env, order: &[u8], memory: &SharedMemory) -> Result<usize, RunnerError>;
}

/// Makes the runner of an episode from its first order.
pub type MakeRunner = fn(&Env, &[u8]) -> Result<Box<dyn Runner>, RunnerError>;

/// Memory that a set of [`Workers`](super::Workers) and its worker processes share: f32 numbers, 0 at first.
///
/// Reads and writes are not ordered by themselves. What was written before [`VecEnv::send_fragment`](super::VecEnv::send_fragment)
/// is read by the runner, and what the runner wrote is read after [`VecEnv::recv`](super::VecEnv::recv) listed the environment.
#[derive(Clone)]
pub struct SharedMemory(Arc<Region>);

impl fmt::Debug for SharedMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SharedMemory")
    }
}

impl SharedMemory {
    pub(super) fn new(region: Arc<Region>) -> Self {
        Self(region)
    }

    /// Reads numbers from a place on.
    ///
    /// # Panics
    /// When the place is beyond the memory.
    pub fn read(&self, place: usize, numbers: &mut [f32]) {
        self.0.read_shared(place, numbers);
    }

    /// Writes numbers from a place on.
    ///
    /// # Panics
    /// When the place is beyond the memory.
    pub fn write(&self, place: usize, numbers: &[f32]) {
        self.0.write_shared(place, numbers);
    }

    /// Reads f64 numbers, each in the place of two, from a place on.
    ///
    /// # Panics
    /// When the place is beyond the memory.
    pub(super) fn read_f64(&self, place: usize, numbers: &mut [f64]) {
        self.0.read_shared_f64(place, numbers);
    }

    /// Writes f64 numbers, each in the place of two, from a place on.
    ///
    /// # Panics
    /// When the place is beyond the memory.
    pub(super) fn write_f64(&self, place: usize, numbers: &[f64]) {
        self.0.write_shared_f64(place, numbers);
    }
}
