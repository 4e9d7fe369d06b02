//! Building models for control: reading, sizing and making systems controllable.

pub mod band;
mod building_type;
pub mod calibration;
mod class;
pub mod description;
pub mod edit;
mod energy;
mod error;
pub mod hvac;
pub mod import;
pub mod model;
pub mod morphology;
pub mod parameter;
mod period;
mod prepare;
mod run_period;
pub mod sizing;
pub mod user_file;
mod zone_role;

pub use band::{Change, Span, ZoneYear};
pub use building_type::{BuildingType, Day, Prototype, TypeData};
pub use class::Class;
pub use description::Description;
pub(crate) use energy::{hvac_energy, monthly_energy, output_database, outputs};
pub use error::{Error, Result};
pub use hvac_energy::{Carrier, CarrierEnergy, EndUse, EndUseEnergy, HvacMeter};
pub use model::{Model, construction, opening, people, shape, zone};
pub use monthly_energy::MonthlyEnergy;
pub use morphology::Morphology;
pub use parameter::Parameter;
pub use period::Period;
pub use prepare::{Conditioning, Controls, OutdoorAir, PreparedBuilding, Zone};
pub use run_period::{Date, RunPeriod};
pub use sizing::Sizes;
pub use zone_role::ZoneRole;
