//! Evaluations: episodes under a policy, many in parallel.
//!
//! Threads take episodes from a list, building by building. Each thread has its own pool of processes, in which it
//! prepares the building and runs its episodes one after another. Memory grows with the number of threads, not with the
//! list, and a process that dies loses one episode, or one [sequence](sequences) of a policy that keeps its memory.

mod bench;
mod episode;
mod finished;
mod folder;
mod info;
mod parallel;
mod progress;
mod recording;
mod resource;
mod result;
mod rollout;
mod runner;
mod sequence;
mod step_rewards;

pub use episode::EpisodePlan;
pub use finished::{EpisodeRecord, Finished, Lost, Outcome};
pub use folder::{Folder, read_kept};
pub use info::EpisodeInfo;
pub use parallel::Evaluation;
pub use progress::Progress;
pub use recording::Recorded;
pub use resource::{RESOURCE, heading_of, resource_heading};
pub use result::deviations::Deviations;
pub use result::hours::Hours;
pub use result::table::{episode_table, read_episodes, read_stages, write_episodes, write_stages};
pub use result::{EpisodeResult, Scored, relative_energy, relative_resource};
pub use runner::KeepRecorded;
pub use sequence::sequences;
pub use step_rewards::StepRewards;
