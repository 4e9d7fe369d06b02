//! Climate: what a model needs to know of its place.

pub mod epw;
pub mod site;

pub use site::{DesignDay, Site};
