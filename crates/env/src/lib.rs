//! Buildings as reinforcement-learning environments on EnergyPlus.
//!
//! An [`Environment`] consists of a prepared building, a weather file, a [`Task`] and a run period. One step is one zone
//! time step of EnergyPlus: the action is applied, the engine advances, the observation is the state at the end of the
//! step, and energy is the meter reading of that step.
//!
//! [`Env`] runs EnergyPlus in this process. A [`Controller`] chooses the actions, and [`rollout`] runs a whole episode under
//! it. The crate `b2b-workers` runs environments in worker processes.

mod action;
mod attributes;
pub mod authority;
mod band;
mod billing;
mod calendar;
mod carbon_dioxide;
mod comfort;
mod controller;
mod cost_scale;
mod decisions;
mod energy_scale;
mod engine_report;
#[allow(clippy::module_inception, reason = "one file a concept, and the concept is the environment")]
mod env;
mod environment;
mod episode_metrics;
mod error;
mod faults;
mod inputs;
mod kpis;
mod limits;
mod metrics;
mod morphology;
mod observation;
mod oscillation;
mod presence;
mod preview;
mod random;
mod reward;
mod role_observation;
mod rollout;
mod setpoints;
mod spaces;
mod task;
mod terms;
mod trajectory;
mod ventilation;
mod zone_air;
mod zones;

pub use action::{ActionSpace, rescale, unscale};
pub use attributes::{attribute_name, attributes};
pub use b2b_tariff as tariff;
pub use band::{Band, Bands, Days, HoursPair, NextPair, Pair};
pub use billing::{Billed, ElectricityPrice};
pub use carbon_dioxide::CarbonDioxide;
pub use comfort::{Comfort, Pmv};
pub use controller::Controller;
pub use cost_scale::CostScale;
pub use decisions::{DecisionLog, DecisionSlot, Decisions};
pub use energy_scale::EnergyScale;
pub use engine_report::{BillPart, EngineReport};
pub use env::{Env, Snapshot};
pub use environment::{Environment, Step};
pub use episode_metrics::{EpisodeMetrics, MetricColumn, MetricValue};
pub use error::{Error, Result};
pub use faults::Faults;
pub use inputs::Inputs;
pub use kpis::Kpis;
pub use metrics::{Metrics, ZoneMetrics};
pub use morphology::Decomposition;
pub use observation::{ObservationSpace, Slot, Target};
pub use presence::Presence;
pub use preview::{PREVIEW_HOURS, Preview};
pub use reward::{
    InfoNumbers, Reward, RewardFunction, StepNumbers, StepView, ZoneStep, from_numbers, to_info_numbers,
    to_numbers,
};
pub use role_observation::{RoleObservation, RoleSlot, RoleValue};
pub use rollout::{Observer, rollout};
pub use setpoints::{RandomDay, RandomHour, Setpoints};
pub use spaces::{EpisodeConfig, Spaces};
pub use task::{DataFile, Fuels, HeatingOnlyZones, Hourly, OPERATION_WEIGHT, Task};
pub use terms::{Amounts, Display, Penalty, RESOURCES, Resource, Term, TermMetrics, Totals};
pub use trajectory::Trajectory;
pub use ventilation::Ventilation;
pub use zone_air::ZoneAir;
pub use zones::ControlledZone;
