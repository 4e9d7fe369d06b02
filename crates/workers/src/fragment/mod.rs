//! Fragments: sequences of steps that a worker runs without its owner.
//!
//! Exchanging every step with the owner costs more than a step of a small building. A program with its own policy, such
//! as a learner, therefore gives its workers a [`Runner`] ([`run_if_worker_with`](super::run_if_worker_with)), requests
//! fragments ([`VecEnv::send_fragment`](super::VecEnv::send_fragment)) and reads the results in [`SharedMemory`].

pub(crate) mod rollout;

use std::fmt;
use std::sync::Arc;

use super::region::Region;
use b2b_env::Env;

/// An error of a runner. The episode is then lost, with the error as the reason.
pub type RunnerError = Box<dyn std::error::Error>;

/// Runs fragments of one episode inside its worker process.
pub trait Runner {
    /// Executes an order: any number of steps of the episode, but not beyond its end. Returns the number of steps.
    ///
    /// # Errors
    /// Any error loses the episode.
    fn run(&mut self, env: &mut Env, order: &[u8], memory: &SharedMemory) -> Result<usize, RunnerError>;

    /// Returns whether this runner can execute an order. If not, for example for another controller, the worker makes
    /// another runner.
    fn serves(&self, _order: &[u8]) -> bool {
        true
    }
}

/// Makes a runner from the first order of an episode, or from an order that the previous runner does not serve.
pub type MakeRunner = fn(&Env, &[u8]) -> Result<Box<dyn Runner>, RunnerError>;

/// The runners that a program's workers can make, by the kind that a request names.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runners(pub &'static [(&'static str, MakeRunner)]);

impl Runners {
    /// Makes a runner.
    ///
    /// # Errors
    /// Errors for a kind that the program does not have; errors from the runner.
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

/// Memory shared by a set of [`Workers`](super::Workers) and its processes: f32 numbers, initially 0.
///
/// Reads and writes are synchronized only by the exchange of fragments: the runner sees writes before
/// [`VecEnv::send_fragment`](super::VecEnv::send_fragment), and the owner sees the runner's writes after
/// [`VecEnv::recv`](super::VecEnv::recv) has listed the environment.
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
    /// If the range is beyond the memory.
    pub fn read(&self, place: usize, numbers: &mut [f32]) {
        self.0.read_shared(place, numbers);
    }

    /// Writes numbers, beginning at an index.
    ///
    /// # Panics
    /// If the range is beyond the memory.
    pub fn write(&self, place: usize, numbers: &[f32]) {
        self.0.write_shared(place, numbers);
    }

    /// Reads f64 numbers, each stored in two places, beginning at an index.
    ///
    /// # Panics
    /// If the range is beyond the memory.
    pub(super) fn read_f64(&self, place: usize, numbers: &mut [f64]) {
        self.0.read_shared_f64(place, numbers);
    }

    /// Writes f64 numbers, each stored in two places, beginning at an index.
    ///
    /// # Panics
    /// If the range is beyond the memory.
    pub(super) fn write_f64(&self, place: usize, numbers: &[f64]) {
        self.0.write_shared_f64(place, numbers);
    }
}
