//! Environments in worker processes: single, in batches, and with mid-episode copies.
//!
//! Only one engine runs at a time in a process, and a crash ends the process, so every episode has its own worker
//! process. A set of [`Workers`] has a template for every setting, which waits at the end of warm-up; an [`Episode`]
//! is a copy of the template by `fork`, within milliseconds, and a [`Snapshot`] is a copy of an episode. [`VecEnv`] is
//! a batch of N environments, and [`recv`] waits for several episodes at once.

mod action;
mod batch;
mod episode;
mod form;
mod fragment;
mod jobs;
mod order;
mod pool;
mod process;
mod region;
mod sampler;
mod setting;
mod time_limit;
mod vec_env;
mod worker;
mod workers;

pub use action::{ActionEnd, ActionProcess};
pub use batch::{recv, step_all};
pub use episode::episode_options::EpisodeOptions;
pub use episode::episode_report::EpisodeReport;
pub use episode::{Episode, Snapshot};
pub use form::{Arranged, Arrangement, EpisodeForm, Form, Padded, RowSlot, check_width};
pub use fragment::rollout::{ControllerRunner, ROLLOUT, RolloutMemory, RolloutOrder};
pub use fragment::{MakeRunner, Runner, RunnerError, Runners, SharedMemory};
pub use jobs::Jobs;
pub use sampler::faults::WithFaults;
pub use sampler::population::{Buildings, Population};
pub use sampler::{
    AnyOf, Draw, Fixed, Kept, Rotating, RoundRobin, Sampler, Weighted, Windows, WithTask, WithWeather,
};
pub use setting::{EpisodeSetting, Source};
pub use vec_env::statistics::Statistics;
pub use vec_env::{Autoreset, VecEnv, VecEnvOptions};
pub use worker::action::{Act, Actions};
pub use worker::entry::{run_if_worker, run_if_worker_with};
pub use workers::Workers;
pub use workers::launcher::Launcher;
pub use workers::worker_options::WorkerOptions;
