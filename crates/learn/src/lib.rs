//! Training of agents: learners, and the collection of their rollouts.
//!
//! A [`Collector`](collector::Collector) steps environments with an actor and writes the steps to a
//! [`Rollout`](rollout::Rollout). A [`Learner`](learner::Learner), such as [`Ppo`](ppo::Ppo) or [`Sac`](sac::Sac),
//! reads the rollout and improves the actor. Learners compute in single precision on the processor. The same seed,
//! rollouts and machine give the same bits, whatever the number of threads. [`offline`] learns from recorded episodes
//! instead.

pub mod collector;
mod comfort_weights;
pub mod credit;
pub mod error;
pub mod fragments;
pub mod gaussian;
pub mod learner;
pub mod learners;
mod limits;
pub mod lockstep;
pub mod nn;
pub mod offline;
mod policy;
pub mod random;
pub mod rollout;
pub mod state;
pub mod train;
mod travel;
mod widths;

pub use comfort_weights::ComfortWeights;
pub use error::{Error, Result};
pub use learners::{ppo, sac};
