//! Controllers on the real engine.

mod commercial;
mod houses;
mod tasks;
