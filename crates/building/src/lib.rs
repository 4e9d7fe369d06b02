//! Building models for control: reading, sizing and making systems controllable.

mod building_type;
pub mod calibration;
mod class;
pub mod construction;
pub mod description;
pub mod edit;
mod error;
pub mod hvac;
mod hvac_energy;
pub mod import;
pub mod model;
mod monthly_energy;
pub mod morphology;
pub mod opening;
mod output_database;
mod outputs;
pub mod parameter;
pub mod people;
mod prepare;
mod run_period;
pub mod shape;
pub mod sizing;
pub mod user_file;
pub mod zone;

pub use building_type::BuildingType;
pub use class::Class;
pub use description::Description;
pub use error::{Error, Result};
pub use hvac_energy::{Carrier, CarrierEnergy, HvacMeter};
pub use model::Model;
pub use monthly_energy::MonthlyEnergy;
pub use morphology::Morphology;
pub use parameter::Parameter;
pub use prepare::{Conditioning, PreparedBuilding, Zone};
pub use run_period::{Date, RunPeriod};
pub use sizing::Sizes;
