//! Arguments that several commands share, each declared once.

pub mod buildings;
pub mod controller;
pub mod episodes;
pub mod jobs;
pub mod location;
pub mod page;
pub mod policy;
pub mod task;
