//! Benchmark runs and their result folders.
//!
//! 1. An [`Entry`] is a policy entered for a problem; its stages are lists of episodes.
//! 2. [`Entry::run`] evaluates them stage by stage and keeps each episode under `unfinished/` as it ends, so that an
//!    interrupted run resumes.
//! 3. A [`RunResult`] remains: `result.json`, `episodes.parquet`, and the policies in `policy/`. Two runs leave the
//!    same bytes on machines that round alike.
//! 4. [`verify`] checks that a folder contains what it claims.

mod adaptation;
mod columns;
mod definition;
mod entry_policy;
mod episode_curve;
mod external;
mod measures;
mod result;
mod run;
mod scores;
mod verify;
mod violation;

pub use adaptation::{Adaptation, Point};
pub use columns::Columns;
pub use definition::Entry;
pub use entry_policy::{EntryPolicy, PolicyDescription};
pub use episode_curve::{EpisodeCurve, EpisodeDifference, EpisodePoint};
pub use external::External;
pub use measures::{Measures, Stratum, mean_from_random, measure_scores};
pub use result::{RunResult, Stages, read_result, rows_of};
pub use run::RunOutcome;
pub use scores::{Performance, Score};
pub use verify::{Check, Sample, TOLERANCE, check, verify};
