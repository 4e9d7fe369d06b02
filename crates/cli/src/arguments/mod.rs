//! Arguments that several commands share, each declared once.

pub mod buildings;
pub mod controller;
#[cfg(target_os = "linux")]
pub mod episodes;
pub mod jobs;
pub mod location;
pub mod page;
#[cfg(target_os = "linux")]
pub mod policy;
pub mod task;
