//! Controllers that do not learn: the sequences of ASHRAE Guideline 36, the paper's reactive control, constant and
//! random actions, replay of recorded actions, a planner on copies of the simulation, schedules for Guideline 36 found
//! with foresight, and model predictive control of its points. Each implements [`Controller`] of `b2b_env`.

mod constant;
mod error;
pub mod foresight;
pub mod guideline36;
mod hold;
mod kind;
pub mod linear_supervisor;
pub mod mpc;
mod noisy;
mod objective;
mod off;
mod own;
mod parameter_set;
mod planner;
mod random;
mod reactive;
mod replay;
mod search;
pub mod tune;
mod tuned;
mod versions;

pub use b2b_env::Controller;
pub use constant::Constant;
pub use error::{Error, Result};
pub use guideline36::{Guideline36, Guideline36Parameters};
pub use kind::{AnyController, Case, Kind, KindDescription, baseline, kind};
pub use noisy::{Noise, Noisy};
pub use objective::Objective;
pub use off::Off;
pub use own::Own;
pub use planner::{Planner, PlannerParameters};
pub use random::Random;
pub use reactive::{AirLoopParameters, Gains, Reactive, ReactiveParameters, TrimRespond, UnitaryParameters};
pub use replay::Replay;
pub use tuned::{Measured, Tuned};
pub use versions::{Versions, kind_hash, parameters_hash};

/// The kinds of controllers that need no file.
pub static KINDS: [&dyn Kind; 11] = [
    &guideline36::Kind,
    &own::Kind,
    &reactive::Kind,
    &hold::Kind,
    &off::Kind,
    &random::Kind,
    &constant::Kind,
    &linear_supervisor::Kind,
    &mpc::Kind,
    &foresight::Kind,
    &planner::Kind,
];
