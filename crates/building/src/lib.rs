//! Building models for control: generate, read, size and make controllable.

pub mod archetype;
pub mod catalog;
mod class;
pub mod climate;
pub mod commercial;
pub mod construction;
pub mod dataset;
pub mod description;

mod error;
pub mod house;
pub mod hvac;
pub mod import;
pub mod model;
pub mod morphology;

pub mod opening;
mod outputs;
mod prepare;
mod run_period;
pub mod sizing;
pub mod zone;

pub use archetype::BuildingType;
pub use catalog::{BuildingName, Catalog, Found, Placement};
pub use class::Class;

pub use description::Description;
pub use error::{Error, Result};
pub use model::Model;
pub use morphology::Morphology;

pub use prepare::{Conditioning, PreparedBuilding, Zone};
pub use run_period::{Date, RunPeriod};
pub use sizing::Sizes;
