//! Networks: a shape, and a slice of parameters that has it.
//!
//! Parameters are one flat slice, which an optimizer steps, a worker shares and a file holds. Layer by layer it has the weights,
//! inputs × outputs in rows of outputs, and the biases. A [`Shape`] is a multilayer perceptron, or a [graph network](graph). An
//! [`Actor`] is a network with the distribution of its actions.

mod activation;
mod actor;
mod exp;
pub mod graph;
mod mlp;
mod shape;

pub use activation::{Activation, tanh};
pub use actor::{Actor, Distribution, LOG_STD, Scratch};
pub use exp::exp;
pub use graph::{Edges, Graph, GraphNetwork};
pub use mlp::{Layer, Mlp};
pub use shape::{Shape, Tensor};
