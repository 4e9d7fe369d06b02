//! Places, their weather files, climate zones and design days.

mod clear_sky;
mod degree_days;
pub mod epw;
mod epw_file;
mod error;
mod location;
mod morph;
pub mod region;
pub mod site;
mod station;
mod sun;
mod two_weeks;
pub mod weather;
mod zone;

pub use degree_days::DegreeDays;
pub use epw_file::EpwFile;
pub use error::{Error, Result};
pub use location::{Location, WeatherFile};
pub use morph::{MORPH_VERSION, morph};
pub use region::Region;
pub use site::{DesignDay, Site};
pub use station::{DesignConditions, MonthNormals, Station};
pub use two_weeks::{TWO_WEEKS, TwoWeeks};
pub use weather::{PLACES, Place};
pub use zone::ClimateYear;
