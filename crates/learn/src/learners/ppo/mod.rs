//! Proximal policy optimization (Schulman et al. 2017), with the details of Stable-Baselines3's `PPO`.
//!
//! An update has these stages:
//!
//! 1. Values and log densities of the steps of the rollout, under the parameters that made them.
//! 2. Advantages and returns of each part of the reward, by generalized advantage estimation ([`advantage`]). Each
//!    action is credited with the parts that it affects ([`credit`](crate::credit)).
//! 3. Epochs of minibatches: losses ([`loss`]) and gradients, clipped, and a step of Adam.
//!
//! Networks with a memory learn from whole sequences of steps, from the states that they had before each sequence in
//! the first stage; gradients end at its first step (truncated backpropagation through time).
//!
//! Actions follow a diagonal Gaussian and are not bounded: they are clipped when they are applied. Actor and critic are
//! separate networks.

pub mod advantage;
mod as_learner;
mod config;
mod features;
mod learner;
pub mod loss;
mod networks;
mod samples;
mod scale;
mod sequences;
mod update;
mod worker;

pub use config::{LogStd, PpoConfig};
pub use learner::Ppo;
pub use update::Update;

#[cfg(test)]
mod graph_tests;
#[cfg(test)]
mod tests;
