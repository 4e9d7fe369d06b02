//! Training of networks over flat parameters: products of matrices, batched passes, initialization and optimization.

mod adam;
mod cell;
pub mod graph;
mod orthogonal;
mod parallel;
mod pass;
mod product;
mod recurrent;
mod schedule;

pub use adam::{Adam, clip_norm};
pub(crate) use b2b_agent::network::graph::sized;
pub use cell::Sequences;
pub use orthogonal::{InitialGains, orthogonal};
pub use parallel::{chunk, chunk_count, for_each, threads_for};
pub use pass::Pass;
pub use product::{Matrix, multiply};
pub use recurrent::RecurrentPass;
pub(crate) use recurrent::initialize as initialize_recurrent;
pub use schedule::RateSchedule;

#[cfg(test)]
pub(crate) mod reference;
