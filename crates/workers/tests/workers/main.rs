//! Environments in worker processes, on the real engine.

mod actions;
mod batch;
#[path = "../../../env/tests/env/case.rs"]
mod case;
mod copies;
mod jobs;
mod losses;
mod operations;
mod processes;
mod report;
mod sampler;
mod succession;
mod templates;
mod workers;
