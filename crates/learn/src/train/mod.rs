//! Training runs: from a configuration to an agent's folder.
//!
//! 1. A [`TrainConfig`] says what to train on, what the agent observes and how it acts, and how it learns.
//! 2. [`train`] collects rollouts in worker processes, updates the learner, evaluates the agent now and then against the reactive
//!    controllers, and writes checkpoints, so that a run that was killed continues to the same weights.
//! 3. The folder of a run is an agent's: the best one so far. `last/` has the last one.

mod check;
mod checkpoint;
mod config;
mod curve;
mod days;
mod environments;
mod journal;
mod judge;
mod learner;
mod lock;
mod measure;
mod noise;
mod one_or_many;
mod paired;
mod policy;
mod problem;
mod progress;
mod run;
mod staggered;
mod suggestion;
mod tasks;
mod tensorboard;

pub use checkpoint::CHECKPOINT;
pub use config::{Algorithm, EvaluationConfig, Keep, TrainConfig};
pub use curve::PAGE;
pub use judge::{BuildingScores, Measures, Scores};
pub use measure::{Design, TrainingLoop, UpdateTimes};
pub use policy::{GraphPolicy, Policy};
pub use progress::{Row, TABLE, read_column};
pub use run::{CONFIG, LAST, Monitor, Place, SUMMARY, Summary, train};
pub use tasks::Tasks;
