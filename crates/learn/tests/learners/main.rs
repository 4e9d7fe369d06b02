//! Learners on toy environments, and a learner from outside of the crate.

mod ppo;
#[cfg(target_os = "linux")]
mod random_search;
mod sac;
mod toy;
