//! Experiments: agents to train and evaluate on given buildings, and a report of the results.
//!
//! An [`Experiment`] is a TOML file. With a [`BudgetName`] it expands to independent [`Job`]s, each a few `b2b`
//! commands in a folder of its own: a training and the evaluation of its agent, the trainings of a benchmark problem and
//! their entry, an evaluation of the reactive controllers, or a measurement. A [`Runner`] starts them as processes, as
//! many at a time as there are cores, and resumes after an interruption. [`Results`] reads the folder, and [`report`]
//! writes one page that shows them beside the results of the paper.

mod check;
mod definition;
mod entry;
mod error;
mod estimate;
mod expansion;
mod folder;
mod job;
mod paper;
pub mod report;
mod results;
mod runner;
mod shard;

pub use check::{Checked, check};
pub use definition::{Agent, Budget, BudgetName, Experiment, ReportKind, Training};
pub use error::{Error, Result};
pub use estimate::{duration_text, estimate};
pub use folder::{Folder, State};
pub use job::{Action, Entry, Episodes, Job};
pub use results::{JobResult, Results};
pub use runner::{Ended, OWNER, Runner};
pub use shard::Shard;
