//! Runs jobs, and evaluates their agents again.

mod arguments;
mod check;
mod runner;

pub use check::{Checked, check};
pub use runner::{Ended, OWNER, Runner};
