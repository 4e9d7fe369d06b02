//! Evaluation of policies: episodes in many buildings, scores against baseline controllers, and reports.
//!
//! 1. A [`Policy`] makes a controller for an episode: one of the [`BuiltIn`] controllers, an [`OnnxPolicy`], or any
//!    other implementation.
//! 2. [`Evaluation`] runs a list of [`EpisodePlan`]s under a policy, in parallel worker processes, and passes each on
//!    as it ends.
//! 3. [`Baselines`] has the returns of the baseline for the same episodes: shipped, cached, or computed.
//!    [`normalized_score`] is the ratio of the two returns; [`score_at_comfort`] is the ratio of the two costs plus a
//!    penalty for discomfort, in operation tasks.
//! 4. [`statistics`] and [`report`] aggregate the scores.
//! 5. A [`problem`] names the episodes that agents may be trained on, and those that they are tested on.

pub mod any_number;
mod baseline;
mod bootstrap;
mod error;
mod evaluation;
pub mod operation_reward;
mod output;
mod panics;
mod parquet_file;
mod policy;
pub mod problem;
pub mod report;
mod results;
mod return_terms;
mod scores;
pub mod statistics;
mod subject;
mod summary;
mod tuned;

pub use baseline::table as baseline_table;
pub use baseline::{Baselines, Key};
pub use error::{Error, Result};
pub use evaluation::{
    Deviations, EpisodeInfo, EpisodePlan, EpisodeRecord, EpisodeResult, Evaluation, Finished, Folder, Hours,
    KeepRecorded, Lost, Outcome, Progress, Recorded, Scored, StepRewards, episode_table, heading_of,
    read_episodes, read_kept, read_stages, relative_energy, relative_resource, resource_heading, sequences,
    write_episodes, write_stages,
};
pub use output::read_rows;
pub use panics::panic_message;
pub use parquet_file::read_parquet;
pub use policy::{
    Ablation, ActionScale, BuiltIn, EpisodeContext, HouseForm, OnnxPolicy, Policy, PolicyForm,
    PolicyInterface, is_agent, is_onnx, without_noise,
};
pub use results::{Results, run_part};
pub use return_terms::ReturnTerms;
pub use scores::{
    Baseline, DISCOMFORT_COST, FREE_DISCOMFORT, Operated, RESOLUTION, Scores, excess_discomfort,
    normalized_score, resolved_score, score_at_comfort,
};
pub use subject::{SiteInfo, Subject, hash_of};
pub use summary::{Group, OperationComfort, Summary, Window, type_label};
pub use tuned::{controller_parameters, task_for};
