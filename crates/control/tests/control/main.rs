//! Controllers on the real engine.

mod commercial;
mod guideline36;
mod houses;
mod tasks;
