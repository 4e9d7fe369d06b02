//! Climate: the places whose weather is known, their files, and what a model needs to know of a place.

mod clear_sky;
pub mod epw;
pub mod site;
pub mod weather;

pub use site::{DesignDay, Site};
pub use weather::{PLACES, Place};
