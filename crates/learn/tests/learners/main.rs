//! Learners on toy environments, a learner from outside the crate, and rollouts on the real engine.

mod collectors;
mod ppo;
mod random_search;
mod recurrent;
mod rollouts;
mod sac;
mod toy;
