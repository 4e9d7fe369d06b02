//! Controllers that need no learning: reactive after ASHRAE Guideline 36, constant, random, a
//! planner on copies of the simulation, and what was done before.
//!
//! A [`Controller`] maps an observation to an action, as a policy does, and may keep state between steps.

mod constant;
mod error;
#[cfg(target_os = "linux")]
mod planner;
mod random;
mod reactive;
mod replay;
#[cfg(target_os = "linux")]
pub mod tune;
mod tuned;

pub use constant::Constant;
pub use error::{Error, Result};
#[cfg(target_os = "linux")]
pub use planner::{Planner, PlannerParameters};
pub use random::Random;
pub use reactive::{
    AirLoopParameters, Gains, Parameter, Reactive, ReactiveParameters, TrimRespond, UnitaryParameters,
};
pub use replay::Replay;
pub use tuned::{Measured, Tuned};

/// Something that acts on an environment.
pub trait Controller {
    /// Forgets everything: a new episode begins.
    fn reset(&mut self);

    /// Writes the action for an observation. Both in the order and the units of the environment's spaces.
    fn act(&mut self, observation: &[f64], action: &mut [f64]);
}

/// The example in the documentation, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/rust.md")]
struct Documentation;
