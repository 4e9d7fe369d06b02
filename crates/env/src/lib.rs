//! Buildings as reinforcement-learning environments on EnergyPlus.
//!
//! An [`Env`] is composed of a prepared building, a weather file, a [`Task`] and a run period. One step is one
//! zone time step of the engine: the action is set, the engine computes, the observation is the state at the
//! end of the step, and energy is that step's meter reading, counted once.

mod action;
pub mod authority;
mod comfort;
mod energy_scale;
#[allow(clippy::module_inception, reason = "one file a concept, and the concept is the environment")]
mod env;
mod episode_metrics;
mod error;
mod metrics;
mod morphology;
mod observation;
mod reward;
mod setpoints;
mod task;
mod trajectory;
#[cfg(target_os = "linux")]
pub mod vector;
mod warmup;

pub use action::ActionSpace;
pub use comfort::{Comfort, Pmv};
pub use energy_scale::EnergyScale;
pub use env::{Env, Episode, Snapshot, Step};
pub use episode_metrics::{EpisodeMetrics, MetricColumn, MetricValue};
pub use error::{Error, Result};
pub use metrics::{Metrics, ZoneMetrics};
pub use morphology::Decomposition;
pub use observation::{ObservationSpace, Slot, Target};
pub use reward::{Reward, RewardFunction, StepView, ZoneStep};
pub use setpoints::{RandomDay, RandomHour, Setpoints};
pub use task::{Fuels, HeatingOnlyZones, Hourly, Resource, Task};
pub use trajectory::Trajectory;
