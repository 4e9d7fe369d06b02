//! Arguments that several commands share, each declared once.

pub mod buildings;
pub mod controller;
pub mod jobs;
pub mod location;
#[cfg(target_os = "linux")]
pub mod policy;
pub mod task;
