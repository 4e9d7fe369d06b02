//! Experiments: agents to train and evaluate on given buildings, and a report of the results.
//!
//! An [`Experiment`] is a TOML file. With a [`Budget`] it expands to independent [`Job`]s, each a few actions in its
//! own folder: a training run and the evaluation of its agent, the training runs for a benchmark problem and their
//! entry, an evaluation of a controller, or a measurement. A [`Runner`] runs them, several at a time, each action in a
//! process of its own in which a [`Program`] carries it out, and resumes after an interruption. [`Results`] reads the
//! folder, [`report`] writes a page that compares them with the paper's results, and [`claims`] judges the paper's
//! claims.

mod absolute;
pub mod claims;
mod definition;
mod error;
mod estimate;
mod folder;
mod job;
mod paper;
mod rates;
pub mod report;
mod results;
mod run;

pub use definition::{Agent, Benchmark, Budget, Buildings, Experiment, Policy, ReportKind, Training};
pub use error::{Error, Result};
pub use estimate::{duration_text, estimate};
pub use folder::{Evaluated, Folder, JobFolder, JobResult, State};
pub use job::{Action, Entry, Episodes, Job, Measurement};
pub use rates::{Rate, rates, rates_text};
pub use results::Results;
pub use run::{ACTION, Checked, Program, Runner, check};
