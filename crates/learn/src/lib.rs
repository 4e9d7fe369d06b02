//! Training of agents.

pub mod rollout;
