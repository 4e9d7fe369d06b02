//! Controllers without learning: reactive control after ASHRAE Guideline 36, constant and random actions, replay of recorded
//! actions, and a planner on copies of the simulation.

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

/// A controller of an environment: maps observations to actions, and may keep state between steps.
pub trait Controller {
    /// Resets internal state at the start of an episode.
    fn reset(&mut self);

    /// Writes the action for an observation, in the order and units of the environment's spaces.
    fn act(&mut self, observation: &[f64], action: &mut [f64]);
}

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
