//! Buildings as reinforcement-learning environments on EnergyPlus.
//!
//! An [`Env`] consists of a prepared building, a weather file, a [`Task`] and a run period. One step is one zone time
//! step of EnergyPlus: the action is applied, the engine advances, the observation is the state at the end of the step,
//! and energy is the meter reading of that step.

mod action;
pub mod authority;
mod calendar;
mod comfort;
mod energy_scale;
#[allow(clippy::module_inception, reason = "one file a concept, and the concept is the environment")]
mod env;
mod error;
mod limits;
mod metrics;
mod morphology;
mod observation;
pub mod random;
mod reward;
mod setpoints;
mod task;
mod trajectory;
#[cfg(target_os = "linux")]
pub mod vector;
mod warmup;
mod zones;

pub use action::{ActionSpace, rescale};
pub use comfort::{Comfort, Pmv};
pub use energy_scale::EnergyScale;
pub use env::{Env, Episode, Snapshot, Step};
pub use error::{Error, Result};
pub use metrics::{Metrics, ZoneMetrics};
pub use morphology::Decomposition;
pub use observation::{ObservationSpace, Slot, Target};
pub use reward::{Reward, RewardFunction, StepView, ZoneStep};
pub use setpoints::{RandomDay, RandomHour, Setpoints};
pub use task::{Fuels, HeatingOnlyZones, Hourly, Resource, Task};
pub use trajectory::Trajectory;
