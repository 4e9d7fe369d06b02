//! Building models for control: read, size and make controllable.

pub mod climate;
mod error;
pub mod hvac;
pub mod model;
pub mod sizing;

pub use error::{Error, Result};
pub use model::Model;
pub use sizing::Sizes;
