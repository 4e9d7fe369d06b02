//! Networks: a shape, and a slice of parameters that has it.
//!
//! Parameters are one flat slice, which an optimizer steps, a worker shares and a file holds. Layer by layer it has the weights,
//! inputs × outputs in rows of outputs, and the biases.

mod activation;
mod mlp;

pub use activation::{Activation, tanh};
pub use mlp::{Layer, Mlp};
