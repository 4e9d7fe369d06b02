//! The configuration of a training run, as a TOML file or as a preset with changes.
//!
//! Each part of it checks its own values. In a file, the options of all parts are side by side, except for two tables:
//! `evaluation`, and the learner's, named by `algorithm`.

mod agent;
mod budget;
mod checkpoints;
mod evaluation;
mod file;
mod idle;
mod noise;
mod one_or_many;
mod preset_choice;
mod rewards;
mod tasks;
mod train_config;
mod training_set;

pub use agent::AgentConfig;
pub use budget::Budget;
pub use checkpoints::{CheckpointConfig, Keep};
pub use evaluation::EvaluationConfig;
pub use file::{CONFIG, merge};
pub use noise::NoiseConfig;
pub use preset_choice::PresetChoice;
pub use rewards::RewardConfig;
pub use tasks::Tasks;
pub use train_config::TrainConfig;
pub use training_set::TrainingSet;

#[cfg(test)]
mod tests;
