//! The jobs of an experiment.

mod action;
mod entry;
mod expansion;

pub use action::{AGENT, Action, Entry, Episodes, Job, LAST_AGENT, Measurement};
