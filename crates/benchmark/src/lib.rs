//! How good a policy is: episodes of many buildings, scores against the reactive controllers, and a report.
//!
//! 1. A [`Policy`] acts: one of the [`BuiltIn`] controllers, an [`OnnxPolicy`], or anything else that makes a
//!    controller for a building. How it came about is not known here.
//! 2. [`Evaluation`] runs a list of [`Episode`]s under it, in parallel, each in a process of its own, and keeps each
//!    as it ends.
//! 3. [`Baselines`] has what the reactive controllers get for the same episodes: shipped, cached, or computed.
//!    [`normalized_score`] is the ratio.
//! 4. [`statistics`] and [`report`] sum up.
#![cfg(target_os = "linux")]

mod baseline;
pub mod entry;
mod error;
mod evaluation;
mod policy;
pub mod problem;
pub mod report;
mod results;
mod scores;
pub mod statistics;
mod subject;

pub use baseline::table as baseline_table;
pub use baseline::{Baselines, Key, Terms, controller_parameters, task_for};
pub use error::{Error, Result};
pub use evaluation::{
    Deviations, Episode, Evaluation, Finished, Folder, Hours, Outcome, Progress, Record, Row, Versions,
    episode_table, read_stages, write_episodes, write_stages,
};
pub use policy::{ActionScale, Beginning, BuiltIn, Interface, OnnxPolicy, Policy};
pub use problem::Problem;
pub use results::{Group, Lost, Results, Summary, Window};
pub use scores::normalized_score;
pub use subject::{Subject, Surroundings};
