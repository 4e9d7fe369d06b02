//! The course of a run: a table, TensorBoard events and a page with the learning curve.

pub(super) mod curve;
mod journal;
mod table;
mod tensorboard;

pub use curve::PAGE;
pub(super) use table::ProgressFiles;
pub use table::{ProgressRow, TABLE, read_column};
