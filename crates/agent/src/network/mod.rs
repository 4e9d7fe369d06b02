//! Networks: a shape and a slice of parameters.
//!
//! Parameters are one flat slice, shared by optimizer, workers and files. It has, layer by layer, the weights (inputs ×
//! outputs, row-major) and the biases. A [`Shape`] is a multilayer perceptron, a [recurrent network](recurrent), or a
//! [graph network](graph). An [`Actor`] is a network with the distribution of its actions.

mod activation;
mod actor;
mod exp;
pub mod graph;
mod memory_span;
mod mlp;
pub mod recurrent;
mod shape;

pub use activation::{Activation, tanh};
pub use actor::{Actor, Distribution, LOG_STD, Scratch};
pub use exp::exp;
pub use graph::{Edges, Graph, GraphNetwork};
pub use memory_span::MemorySpan;
pub use mlp::{Layer, Mlp};
pub use recurrent::Recurrent;
pub use shape::{Shape, Tensor};
