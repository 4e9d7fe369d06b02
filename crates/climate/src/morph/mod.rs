//! Weather of a Québec station, morphed from Montréal's typical year.
//!
//! Shift and stretch after Belcher, Hacker and Powell (2005), month by month:
//! - dry bulb: daily means are shifted and stretched to the station's monthly mean and standard deviation; the swing
//!   around their trend is scaled to the station's daily range;
//! - dew point: daily means are stretched like dry-bulb means, shifted to the monthly mean, and kept below the dry
//!   bulb; humidity and long-wave sky radiation follow;
//! - sun: the clearness index of each hour under the station's sun path is scaled to the monthly total and split again
//!   into beam and diffuse;
//! - wind is scaled, pressure follows the elevation, ground temperatures follow the air's annual mean and amplitude.
//!
//! The sequence of warm and cold, calm and windy days, sky cover, rain and snow remain Montréal's.

mod header;
mod months;
mod sky;
mod year;

use std::path::Path;

use crate::Result;
use crate::epw::Record;
use crate::station::Station;
use header::{location, malformed, write_header};
use months::HOURS;
use year::Year;

/// Version of the files that [`morph`] writes; it changes with their bytes.
pub const MORPH_VERSION: u32 = 1;

/// Returns the weather of a station as an EPW text, morphed from `base_epw`.
///
/// The bytes are the same on every machine.
///
/// # Errors
/// [`crate::Error::Malformed`] when the base is not a complete common year, or its LOCATION has no coordinates.
pub fn morph(base_epw: &str, station: &Station) -> Result<String> {
    let path = Path::new("base.epw");
    let record = Record::of(base_epw, path)?;
    if record.hours().len() != HOURS || !record.is_whole_year() || record.intervals() != 1 {
        return Err(malformed("expected the 8760 hours of a common year"));
    }
    let mut lines = base_epw.lines();
    let header: Vec<&str> = lines.by_ref().take(8).collect();
    let base = Year::read(lines.filter(|line| !line.trim().is_empty()));
    let place = location(header[0])?;
    let year = base.moved_to(station, place);
    let mut text = String::with_capacity(base_epw.len());
    write_header(&mut text, &header, station, &base.dry_bulb);
    year.write(&mut text);
    Ok(text)
}

#[cfg(test)]
mod tests;
