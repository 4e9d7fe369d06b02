//! Building models for control: read, size and make controllable.

pub mod climate;
mod error;
pub mod house;
pub mod model;

pub use error::{Error, Result};
pub use model::Model;
