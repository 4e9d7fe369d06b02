//! Soft actor-critic (Haarnoja et al. 2018a, "Soft actor-critic"; 2018b, "Soft actor-critic algorithms and
//! applications"), with the details of Stable-Baselines3's `SAC`.
//!
//! An update adds a rollout to the replay buffer ([`replay`]) and learns from minibatches of it. Each has these stages:
//!
//! 1. Critics: returns of one or several steps, and the value of the target critics after them.
//! 2. Target critics, which follow the critics.
//! 3. Actor: a squashed Gaussian, through the smaller value of the critics ([`loss`]).
//! 4. Temperature, toward a target entropy.
//!
//! Rewards are the sums of their parts.

mod as_learner;
mod config;
mod learner;
pub mod loss;
mod networks;
pub mod replay;
mod update;
mod worker;

pub use config::SacConfig;
pub use learner::Sac;
pub use update::SacUpdate;

#[cfg(test)]
mod tests;
