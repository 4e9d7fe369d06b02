//! Runs jobs, and evaluates their agents again.

mod check;
mod order;
mod program;
mod runner;

pub use check::{Checked, check};
pub use program::Program;
pub use runner::{ACTION, Runner};
