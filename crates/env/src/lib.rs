//! Buildings as reinforcement-learning environments on EnergyPlus.
//!
//! An [`Environment`] consists of a prepared building, a weather file, a [`Task`] and a run period. One step is one
//! zone time step of EnergyPlus: the action is applied, the engine advances, the observation is the state at the end of
//! the step, and energy is the meter reading of that step.
//!
//! [`Env`] runs EnergyPlus in this process. A [`Controller`] chooses the actions, and [`rollout`] runs a whole episode
//! under it. The crate `b2b-workers` runs environments in worker processes.

pub mod authority;
mod billing;
mod engine_report;
#[allow(clippy::module_inception, reason = "one file a concept, and the concept is the environment")]
mod env;
mod environment;
mod error;
mod faults;
mod forecast;
mod inputs;
mod limits;
mod metrics;
mod preview;
mod random;
mod reward;
mod rollout;
mod setpoints;
mod spaces;
mod task;
mod terms;
mod zones;

pub use b2b_tariff as tariff;
pub use billing::{Billed, ElectricityPrice};
pub use engine_report::{BillPart, EngineReport};
pub use env::{Env, Snapshot};
pub use environment::{Environment, Step};
pub use error::{Error, Result};
pub use faults::Faults;
pub use forecast::Forecast;
pub use inputs::Inputs;
pub use metrics::episode_metrics::{EpisodeMetrics, MetricColumn, MetricValue};
pub use metrics::kpis::Kpis;
pub use metrics::{Metrics, ZoneMetrics};
pub use preview::{PREVIEW_HOURS, Preview};
pub use reward::cost_scale::CostScale;
pub use reward::energy_scale::EnergyScale;
pub use reward::{
    InfoNumbers, Reward, RewardFunction, StepNumbers, StepView, ZoneStep, from_numbers, to_info_numbers,
    to_numbers,
};
pub use rollout::controller::Controller;
pub use rollout::decisions::{DecisionLog, DecisionSlot, Decisions};
pub use rollout::trajectory::Trajectory;
pub use rollout::{Observer, rollout, rollout_next};
pub use setpoints::band::{Band, Bands, Days, HoursPair, NextPair, Pair};
pub use setpoints::{RandomDay, RandomHour, Setpoints};
pub use spaces::action::{ActionSpace, rescale, unscale};
pub use spaces::attributes::{attribute_name, attributes};
pub use spaces::morphology::Decomposition;
pub use spaces::observation::{ObservationSpace, Target};
pub use spaces::role_observation::{RoleObservation, RoleSlot, RoleValue};
pub use spaces::slots::Slot;
pub use spaces::{EpisodeConfig, Spaces};
pub use task::{DataFile, Fuels, Hourly, OPERATION_WEIGHT, Task};
pub use terms::{Amounts, Display, Penalty, RESOURCES, Resource, Term, TermMetrics, Totals};
pub use zones::carbon_dioxide::CarbonDioxide;
pub use zones::comfort::{Comfort, PMV_WEIGHT, Pmv};
pub use zones::presence::Presence;
pub use zones::ventilation::Ventilation;
pub use zones::zone_air::ZoneAir;
pub use zones::{ControlledZone, HeatingOnlyZones};
