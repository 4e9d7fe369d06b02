//! Places, their weather files, climate zones and design days.

mod clear_sky;
mod degree_days;
mod design_day;
mod epw;
mod error;
mod ground;
mod location;
mod mild_year;
mod morph;
pub mod region;
mod site;
mod station;
mod sun;
mod two_weeks;
pub mod weather;
mod zone;

pub use degree_days::DegreeDays;
pub use design_day::DesignDay;
pub use epw::{EpwFile, Hour, Record};
pub use error::{Error, Result};
pub use location::{Location, WeatherFile};
pub use mild_year::mild_year;
pub use morph::{MORPH_VERSION, morph};
pub use region::Region;
pub use site::Site;
pub use station::{DesignConditions, MonthNormals, Station};
pub use two_weeks::{TWO_WEEKS, TwoWeeks};
pub use weather::{PLACES, Place};
pub use zone::ClimateYear;
