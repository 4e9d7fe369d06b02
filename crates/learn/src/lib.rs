//! Training of agents: learners, and the rollouts they learn from.
//!
//! A [`Collector`](collector::Collector) makes steps with an actor and writes them to a [`Rollout`](rollout::Rollout). A learner,
//! [`Ppo`](ppo::Ppo) or [`Sac`](sac::Sac), reads the rollout and improves the actor. Learners compute in single precision on
//! the processor. [`offline`] learns from recorded episodes instead. The same seed, rollouts and machine give the same bits, whatever the number of threads.

pub mod collector;
mod credit;
pub mod error;
pub mod fragments;
pub mod gaussian;
pub mod lockstep;
pub mod nn;
pub mod offline;
pub mod ppo;
pub mod random;
pub mod rollout;
pub mod sac;
pub mod state;
pub mod train;
mod travel;

pub use error::{Error, Result};
