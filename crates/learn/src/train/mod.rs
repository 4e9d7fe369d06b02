//! Training runs: from a configuration to an agent's folder.
//!
//! 1. A [`TrainConfig`] says what to train on, what the agent observes and how it acts, and how it learns.
//! 2. [`train`] collects rollouts in worker processes, updates the learner, evaluates the agent now and then against
//!    the baseline, and writes checkpoints, so that a killed run resumes and ends with the same weights.
//! 3. The folder of a run is an agent's: the best one so far, or in the end the last one with [`Keep::Last`]. `last/`
//!    has the last one.

mod calibration;
mod checkpoint;
mod config;
mod environments;
mod judge;
mod lock;
mod measure;
mod monitor;
mod problem;
mod progress;
mod run;
mod sealed_state;
mod side;
mod summary;

pub use crate::policy::{GraphPolicy, PolicyConfig, RecurrentPolicy};
pub use checkpoint::CHECKPOINT;
pub use config::{
    AgentConfig, Budget, CONFIG, CheckpointConfig, EvaluationConfig, Keep, NoiseConfig, PresetChoice,
    RewardConfig, Tasks, TrainConfig, TrainingSet, merge,
};
pub use judge::{AgentScores, BuildingScores, Measures};
pub use lock::LAST;
pub(crate) use lock::acquire;
pub use measure::{Design, TrainingLoop, UpdateTimes};
pub use monitor::Monitor;
pub use progress::{PAGE, ProgressRow, TABLE, read_column};
pub use run::{RunOptions, STAGES, train};
pub use summary::{RunSummary, SUMMARY};
