//! The configuration of a training run, as a TOML file or as presets with changes.
//!
//! It consists of parts, each of which checks its own values. In a file, the options of most parts stand side by side; those of the
//! evaluations and of the learner have a table of their own, the learner's with its name.

mod agent;
mod budget;
mod checkpoints;
mod evaluation;
mod file;
mod noise;
mod one_or_many;
mod rewards;
mod suggestion;
mod tasks;
mod train_config;
mod training_set;

pub use agent::AgentConfig;
pub use budget::Budget;
pub use checkpoints::{CheckpointConfig, Keep};
pub use evaluation::EvaluationConfig;
pub use file::CONFIG;
pub use noise::NoiseConfig;
pub use rewards::RewardConfig;
pub use tasks::Tasks;
pub use train_config::TrainConfig;
pub use training_set::TrainingSet;

#[cfg(test)]
mod tests;
