//! Controllers that need no learning: reactive after ASHRAE Guideline 36, constant, and random.
//!
//! A [`Controller`] maps an observation to an action, as a policy does, and may keep state between steps.

mod constant;
mod random;
mod reactive;

pub use constant::Constant;
pub use random::Random;
pub use reactive::{AirLoopParameters, Gains, Reactive, ReactiveParameters, TrimRespond, UnitaryParameters};

/// Something that acts on an environment.
pub trait Controller {
    /// Forgets everything: a new episode begins.
    fn reset(&mut self);

    /// Writes the action for an observation. Both in the order and the units of the environment's spaces.
    fn act(&mut self, observation: &[f64], action: &mut [f64]);
}

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
