//! The definition of an experiment: a TOML file, shipped or a user's.

mod agent;
mod budget;
mod experiment;
mod shipped;
mod validation;

pub use agent::{Agent, Training};
pub use budget::{Budget, Buildings};
pub use experiment::{Benchmark, Experiment, Policy, RANDOM, REACTIVE, ReportKind, best_of};
