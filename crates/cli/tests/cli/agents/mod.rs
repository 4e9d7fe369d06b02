//! Commands that make agents, and the experiments that compare them.

mod experiment;
mod offline;
mod train;
mod tune;
