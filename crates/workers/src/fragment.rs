//! Fragments: sequences of steps that a worker runs without its owner.
//!
//! Exchanging every single step costs more than a step of a small building. A program with its own policy, such as a
//! learner, therefore gives its workers a [`Runner`] ([`run_if_worker_with`](super::run_if_worker_with)), requests
//! fragments ([`VecEnv::send_fragment`](super::VecEnv::send_fragment)) and reads the results in [`SharedMemory`].

use std::fmt;
use std::sync::Arc;

use super::region::Region;
use b2b_env::Env;

/// An error of a runner. The episode is then lost, with the text of the error as the reason.
pub type RunnerError = Box<dyn std::error::Error>;

/// Runs fragments of one episode inside its worker process.
pub trait Runner {
    /// Carries out an order: any number of steps of the episode. Returns how many it made. Does not step an episode beyond its
    /// end.
    ///
    /// # Errors
    /// Any error ends the episode, which is lost.
    fn run(&mut self, env: &mut Env, order: &[u8], memory: &SharedMemory) -> Result<usize, RunnerError>;

    /// Returns whether this runner can carry out an order. For one that it cannot, such as that of another controller, the worker
    /// makes another runner.
    fn serves(&self, _order: &[u8]) -> bool {
        true
    }
}

/// Makes the runner of an episode from its first request, and from one that the runner before does not serve.
pub type MakeRunner = fn(&Env, &[u8]) -> Result<Box<dyn Runner>, RunnerError>;

/// The runners that a program's workers can make, by the kind that a request names.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runners(pub &'static [(&'static str, MakeRunner)]);

impl Runners {
    /// Makes a runner.
    ///
    /// # Errors
    /// For a kind that the program does not have; those of the runner.
    pub(super) fn make(self, kind: &str, env: &Env, order: &[u8]) -> Result<RunnerOf, RunnerError> {
        let Some((kind, make)) = self.0.iter().find(|(known, _)| *known == kind) else {
            let known: Vec<&str> = self.0.iter().map(|(known, _)| *known).collect();
            return Err(format!("unknown runner `{kind}`; the worker's program has {known:?}").into());
        };
        Ok(RunnerOf { kind, runner: make(env, order)? })
    }
}

/// A runner of a kind.
pub(super) struct RunnerOf {
    kind: &'static str,
    runner: Box<dyn Runner>,
}

impl RunnerOf {
    pub(super) fn serves(&self, kind: &str, order: &[u8]) -> bool {
        self.kind == kind && self.runner.serves(order)
    }

    pub(super) fn run(
        &mut self,
        env: &mut Env,
        order: &[u8],
        memory: &SharedMemory,
    ) -> Result<usize, RunnerError> {
        self.runner.run(env, order, memory)
    }
}

/// Memory that a set of [`Workers`](super::Workers) and its worker processes share: f32 numbers, 0 at first.
///
/// Reads and writes are not synchronized by themselves. What was written before
/// [`VecEnv::send_fragment`](super::VecEnv::send_fragment) is read by the runner, and what the runner wrote is read
/// after [`VecEnv::recv`](super::VecEnv::recv) listed the environment.
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

    /// Reads numbers, beginning at an index.
    ///
    /// # Panics
    /// When the place is beyond the memory.
    pub fn read(&self, place: usize, numbers: &mut [f32]) {
        self.0.read_shared(place, numbers);
    }

    /// Writes numbers, beginning at an index.
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
