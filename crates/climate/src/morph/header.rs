//! The header of a morphed weather file.

use std::fmt::Write;

use super::months::{mean, months};
use crate::station::{DesignConditions, Station};
use crate::sun;
use crate::{Error, Result};

/// The location of the station in an EPW header.
pub(super) struct Location {
    pub(super) sun: sun::Position,
    pub(super) elevation: f64,
}

pub(super) fn location(line: &str) -> Result<Location> {
    let fields: Vec<&str> = line.split(',').collect();
    let number = |index: usize| {
        fields.get(index).and_then(|field| field.trim().parse::<f64>().ok()).filter(|value| value.is_finite())
    };
    let (Some(latitude), Some(longitude), Some(time_zone), Some(elevation)) =
        (number(6), number(7), number(8), number(9))
    else {
        return Err(malformed("LOCATION has no latitude, longitude, time zone and elevation"));
    };
    Ok(Location { sun: sun::Position { latitude, longitude, time_zone }, elevation })
}

pub(super) fn malformed(why: &str) -> Error {
    Error::Malformed { path: "the weather to morph".into(), why: why.into() }
}

pub(super) fn write_header(text: &mut String, header: &[&str], station: &Station, base_dry_bulb: &[f64]) {
    for line in header {
        let (title, rest) = line.split_once(',').unwrap_or((line, ""));
        let line = match title.to_ascii_uppercase().as_str() {
            "LOCATION" => location_line(line, station),
            "DESIGN CONDITIONS" => design_line(station.design.as_ref()),
            "GROUND TEMPERATURES" => format!("{title},{}", ground(rest, station, base_dry_bulb)),
            "COMMENTS 1" => comment(header[0], station),
            "COMMENTS 2" => "COMMENTS 2,Shift and stretch month by month after Belcher et al. 2005 -- \
                             ground temperatures follow the annual mean and amplitude of the air"
                .into(),
            _ => (*line).to_owned(),
        };
        text.push_str(line.trim_end());
        text.push('\n');
    }
}

fn location_line(base: &str, station: &Station) -> String {
    let time_zone = base.split(',').nth(8).unwrap_or_default();
    let (latitude, longitude, elevation) = (station.latitude, station.longitude, station.elevation);
    let (name, wmo) = (station.name, station.wmo);
    format!(
        "LOCATION,{name} (morphed),PQ,CAN,morphed from another station,{wmo},\
         {latitude:.2},{longitude:.2},{time_zone},{elevation:.1}"
    )
}

fn comment(base_location: &str, station: &Station) -> String {
    let fields: Vec<&str> = base_location.split(',').collect();
    let field = |index: usize| fields.get(index).copied().unwrap_or_default();
    let design = match station.design {
        Some(_) => "design conditions of the station",
        None => "no design conditions published: take them from the hours",
    };
    format!(
        "COMMENTS 1,Morphed from {} (WMO {}) to the monthly normals of {} -- not a record -- {design}",
        field(1),
        field(5),
        station.name
    )
}

/// The DESIGN CONDITIONS line, with the known ASHRAE fields.
fn design_line(design: Option<&DesignConditions>) -> String {
    let Some(design) = design else { return "DESIGN CONDITIONS,0".into() };
    let mut heating = ["N/A"; 15];
    heating[0] = design.heating_month;
    heating[1] = design.heating_dry_bulb;
    heating[13..].copy_from_slice(&design.heating_wind);
    let mut cooling = ["N/A"; 32];
    cooling[0] = design.cooling_month;
    cooling[1] = design.cooling_range;
    cooling[2..4].copy_from_slice(&design.cooling_bulbs);
    cooling[14..16].copy_from_slice(&design.cooling_wind);
    let edition = design.edition;
    format!("DESIGN CONDITIONS,1,{edition},,Heating,{},Cooling,{}", heating.join(","), cooling.join(","))
}

/// The row of ground temperatures after its title: count, then a depth, its three soil properties and 12 months.
fn ground(row: &str, station: &Station, base_dry_bulb: &[f64]) -> String {
    let base: Vec<f64> = months().map(|hours| mean(&base_dry_bulb[hours])).collect();
    let here: Vec<f64> = station.months.iter().map(|month| month.dry_bulb).collect();
    let (shift, swing) = (mean(&here) - mean(&base), amplitude(&here) / amplitude(&base));
    let (count, depths) = row.split_once(',').unwrap_or((row, ""));
    let mut text = count.to_owned();
    let fields: Vec<&str> = depths.split(',').collect();
    for depth in fields.chunks(16) {
        let (soil, months) = depth.split_at(4.min(depth.len()));
        let months: Vec<f64> = months.iter().filter_map(|field| field.trim().parse().ok()).collect();
        let annual = mean(&months);
        text.extend(soil.iter().flat_map(|field| [",", field]));
        for month in &months {
            // Writing to a string never fails.
            let _ = write!(text, ",{:.2}", annual + shift + swing * (month - annual));
        }
    }
    text
}

/// Half the difference between the highest and the lowest month.
fn amplitude(months: &[f64]) -> f64 {
    let high = months.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = months.iter().copied().fold(f64::INFINITY, f64::min);
    (high - low) / 2.0
}
