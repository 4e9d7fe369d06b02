//! Runs jobs, and evaluates their agents again.

mod arguments;
mod check;
mod runner;
mod shard;

pub use check::{Checked, check};
pub use runner::{Ended, OWNER, Runner};
pub use shard::Shard;
