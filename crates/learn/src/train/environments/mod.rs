//! The training environments of a configuration.

pub(super) mod days;
mod paired;
mod sampling;
mod scale;
mod staggered;

pub(super) use sampling::{Environments, Evaluated, learner};
