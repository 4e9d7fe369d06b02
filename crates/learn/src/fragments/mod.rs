//! Collection in the workers: each runs a fragment of its episode with a copy of the actor.
//!
//! 1. The owner writes the actor's parameters to shared memory, once for all workers.
//! 2. Each worker runs its fragment ([`RUNNERS`]) and leaves observations, actions and rewards in its block of that
//!    memory.
//! 3. A fragment ends with its episode. The next episode begins in a new worker, whose fragment makes the steps that
//!    the rollout still needs.
//! 4. The owner copies the blocks to the rollout.

mod blocks;
mod building;
mod collector;
mod order;
mod progress;
mod resumption;
mod runner;

pub(crate) use building::GraphBuilding;
pub(crate) use collector::spaces_of;
pub use collector::{FragmentCollector, RewardScale};
pub(crate) use order::stream;
pub use order::{FragmentOrder, Purpose};
pub use runner::RUNNERS;

/// Runs this process as a worker with runners of fragments if it was started as one, and then never returns. Called
/// first in `main`, before a thread is started.
pub fn run_if_worker() {
    b2b_workers::run_if_worker_with(RUNNERS, b2b_workers::Actions::default());
}
