//! Learners on toy environments, a learner from outside of the crate, and rollouts on the real engine.

#[cfg(target_os = "linux")]
mod collectors;
mod ppo;
#[cfg(target_os = "linux")]
mod random_search;
#[cfg(target_os = "linux")]
mod rollouts;
mod sac;
mod toy;
