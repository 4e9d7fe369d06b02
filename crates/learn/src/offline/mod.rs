//! Datasets of recorded episodes, and learning from them.
//!
//! [`collect`] runs policies and writes a dataset in the Parquet format of Minari, which other offline learners read as
//! well; [`Dataset`] reads one, and [`clone_policy`] trains an agent that imitates the recorded actions.

mod cloning;
mod collection;
mod corpus;
mod dataset;
mod episodes;

pub use cloning::{CloneConfig, Cloned, clone_policy};
pub use collection::{Collection, collect};
pub use corpus::{Behavior, Collected, CorpusPart, Definition, History, collect_corpus, train_agents};
pub use dataset::{Contents, CorpusEpisode, Dataset, EpisodeMetadata, ModelReading};
pub use episodes::EpisodeFile;
