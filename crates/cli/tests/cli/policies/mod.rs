//! Commands that score policies, and their results.

mod benchmark;
mod compare;
mod evaluate;
mod evaluation;
mod memory;
pub(crate) mod onnx_file;
mod operation;
mod verification;
