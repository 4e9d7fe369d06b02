//! The benchmark's problems, and the spaces of policies and batches on them.
//!
//! [`WrappedPolicy`] gives a policy the observation and action spaces of the training or test side, and
//! [`TrainingForm`] gives a batch of environments the spaces of the training side.

mod training;
mod wrapper;

pub use b2b_evaluate::problem::*;
pub use training::TrainingForm;
pub use wrapper::WrappedPolicy;
