//! Evaluations: episodes under a policy, many in parallel.
//!
//! Threads take episodes from a list, building by building. Each thread has its own pool of processes, in which it
//! prepares the building and runs its episodes one after another. Memory grows with the number of threads, not with the
//! list, and a process that dies loses one episode.

mod bench;
mod deviations;
mod episode;
mod finished;
mod folder;
mod hours;
mod info;
mod parallel;
mod progress;
mod recording;
mod rollout;
mod row;
mod runner;
mod step_rewards;
mod table;

pub use deviations::Deviations;
pub use episode::Episode;
pub use finished::{Finished, Lost, Outcome, Record};
pub use folder::{Folder, read_kept};
pub use hours::Hours;
pub use info::EpisodeInfo;
pub use parallel::Evaluation;
pub use progress::Progress;
pub use recording::Recorded;
pub use row::{Row, Scored, relative_energy, relative_resource};
pub use runner::KeepRecorded;
pub use step_rewards::StepRewards;
pub use table::{episode_table, read_episodes, read_stages, write_episodes, write_stages};
