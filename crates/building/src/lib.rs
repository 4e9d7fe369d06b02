//! Building models for control: generate, read, size and make controllable.

pub mod archetype;
pub mod climate;
pub mod commercial;
pub mod dataset;
mod error;
pub mod house;
pub mod hvac;
pub mod import;
pub mod model;
mod outputs;
mod prepare;
mod run_period;
pub mod sizing;
pub mod zone;

pub use archetype::BuildingType;
pub use error::{Error, Result};
pub use model::Model;
pub use prepare::{Conditioning, PreparedBuilding, Zone};
pub use run_period::{Date, RunPeriod};
pub use sizing::Sizes;
