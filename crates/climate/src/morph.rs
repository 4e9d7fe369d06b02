//! Weather of a Québec station, morphed from Montréal's typical year.
//!
//! Shift and stretch after Belcher, Hacker and Powell (2005), month by month:
//! - dry bulb: daily means move to the month's mean and spread as the station's daily means do; the swing around
//!   their trend is scaled to the station's daily range;
//! - dew point: daily means spread as those of the dry bulb, move to the month's mean, and stay under the dry bulb;
//!   humidity and long-wave sky radiation follow;
//! - sun: the clearness index of each hour, under the station's own sun, scaled to the month's total and split anew
//!   into beam and diffuse;
//! - wind is scaled, pressure follows the elevation, ground temperatures follow the air's annual mean and amplitude.
//!
//! What stays Montréal's: the sequence of warm and cold, calm and windy days, sky cover, rain and snow.

use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

use super::station::{DesignConditions, MonthNormals, Station};
use super::{epw, sun};
use crate::{Error, Result};

/// Version of the files that [`morph`] writes: changes with their bytes.
pub const MORPH_VERSION: u32 = 1;

const DAYS: [usize; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
const HOURS: usize = 8760;
/// Clearness index that no hour exceeds: a dry, high, clear sky.
const CLEAREST: f64 = 0.82;
/// Sun outside the atmosphere under which an hour's clearness means nothing, Wh/m².
const LOW_SUN: f64 = 30.0;
/// Passes that bring a month to its target where no closed form does.
const PASSES: usize = 30;
/// Stefan and Boltzmann, W/m²K⁴.
const STEFAN_BOLTZMANN: f64 = 5.6697e-8;

/// The weather of a station as an EPW text, morphed from `base_epw`.
///
/// The same bytes on every machine.
///
/// # Errors
/// [`Error::Malformed`] when the base is not a whole common year of hours, or its LOCATION has no coordinates.
pub fn morph(base_epw: &str, station: &Station) -> Result<String> {
    let path = Path::new("base.epw");
    if epw::check(base_epw, path)? != HOURS {
        return Err(malformed("a leap year cannot be morphed: give one of 8760 hours"));
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

/// What an EPW header says of where its station is.
struct Location {
    sun: sun::Place,
    elevation: f64,
}

/// The columns of a year that are morphed, and the lines that hold the others.
struct Year<'a> {
    lines: Vec<&'a str>,
    dry_bulb: Vec<f64>,
    dew_point: Vec<f64>,
    pressure: Vec<f64>,
    global: Vec<f64>,
    wind: Vec<f64>,
    /// Opaque sky cover, tenths.
    cover: Vec<f64>,
    /// The sun over each hour.
    sun: Vec<sun::Sun>,
}

/// Columns of an EPW hour.
mod column {
    pub const DRY_BULB: usize = 6;
    pub const DEW_POINT: usize = 7;
    pub const HUMIDITY: usize = 8;
    pub const PRESSURE: usize = 9;
    pub const EXTRATERRESTRIAL_HORIZONTAL: usize = 10;
    pub const EXTRATERRESTRIAL_NORMAL: usize = 11;
    pub const INFRARED: usize = 12;
    pub const GLOBAL: usize = 13;
    pub const BEAM: usize = 14;
    pub const DIFFUSE: usize = 15;
    pub const ILLUMINANCE: std::ops::RangeInclusive<usize> = 16..=18;
    pub const ZENITH_LUMINANCE: usize = 19;
    pub const WIND: usize = 21;
    pub const COVER: usize = 23;
}

impl<'a> Year<'a> {
    fn read(lines: impl Iterator<Item = &'a str>) -> Self {
        let lines: Vec<&str> = lines.collect();
        let values = |column: usize| {
            // The check has read every column as a number.
            let value = |line: &&str| line.split(',').nth(column).and_then(|v| v.trim().parse().ok());
            lines.iter().map(|line| value(line).unwrap_or_default()).collect()
        };
        Self {
            dry_bulb: values(column::DRY_BULB),
            dew_point: values(column::DEW_POINT),
            pressure: values(column::PRESSURE),
            global: values(column::GLOBAL),
            wind: values(column::WIND),
            cover: values(column::COVER),
            sun: Vec::new(),
            lines,
        }
    }

    fn moved_to(&self, station: &Station, from: Location) -> Self {
        let mut dry_bulb = Vec::with_capacity(HOURS);
        let mut dew_point = Vec::with_capacity(HOURS);
        let mut wind = Vec::with_capacity(HOURS);
        let (dry_bulb_trend, dew_point_trend) = (trend(&self.dry_bulb), trend(&self.dew_point));
        for (month, hours) in months().enumerate() {
            let normals = &station.months[month];
            let own = &self.dry_bulb[hours.clone()];
            let target =
                Target { mean: normals.dry_bulb, spread: normals.daily_spread, range: normals.daily_range };
            let stretch = target.spread / spread(own);
            dry_bulb.extend(target.reached_by(own, &dry_bulb_trend[hours.clone()]));
            let own = &self.dew_point[hours.clone()];
            let target = Target { mean: normals.dew_point, spread: stretch * spread(own), range: range(own) };
            let dew = target.reached_by(own, &dew_point_trend[hours.clone()]);
            dew_point.extend(held_under(dew, &dry_bulb[hours.clone()], normals.dew_point));
            wind.extend(scaled(&self.wind[hours], normals.wind_speed));
        }
        let to = sun::Place { latitude: station.latitude, longitude: station.longitude, ..from.sun };
        let sun = suns(to);
        Self {
            global: self.sun_under(&suns(from.sun), &sun, &station.months),
            pressure: at_elevation(&self.pressure, from.elevation, station.elevation),
            cover: self.cover.clone(),
            lines: self.lines.clone(),
            dry_bulb,
            dew_point,
            wind,
            sun,
        }
    }

    /// Global horizontal of each hour: its clearness under another sun, scaled to the totals of the months.
    fn sun_under(&self, from: &[sun::Sun], to: &[sun::Sun], normals: &[MonthNormals; 12]) -> Vec<f64> {
        let mut global = Vec::with_capacity(HOURS);
        for (month, hours) in months().enumerate() {
            let clearness = clearness(&self.global[hours.clone()], &from[hours.clone()]);
            let target = normals[month].global_horizontal * DAYS[month] as f64;
            global.extend(with_total(&clearness, &to[hours], target));
        }
        global
    }

    fn write(&self, text: &mut String) {
        for (hour, line) in self.lines.iter().enumerate() {
            let mut values: Vec<String> = line.split(',').map(str::to_owned).collect();
            self.overwrite(hour, &mut values);
            text.push_str(&values.join(","));
            text.push('\n');
        }
    }

    fn overwrite(&self, hour: usize, values: &mut [String]) {
        let (dry_bulb, dew_point) = (self.dry_bulb[hour], self.dew_point[hour]);
        let sun = self.sun[hour];
        let global = self.global[hour];
        let (beam, diffuse) = split(global, sun);
        for (column, value) in [
            (column::DRY_BULB, dry_bulb),
            (column::DEW_POINT, dew_point),
            (column::EXTRATERRESTRIAL_HORIZONTAL, sun.horizontal()),
            (column::EXTRATERRESTRIAL_NORMAL, if sun.cosine > 0.0 { sun.extraterrestrial } else { 0.0 }),
            (column::INFRARED, sky_radiation(dry_bulb, dew_point, self.cover[hour])),
            (column::GLOBAL, global),
            (column::BEAM, beam),
            (column::DIFFUSE, diffuse),
            (column::WIND, self.wind[hour]),
        ] {
            values[column] = format!("{value:.1}");
        }
        values[column::HUMIDITY] = format!("{:.0}", humidity(dry_bulb, dew_point));
        values[column::PRESSURE] = format!("{:.0}", self.pressure[hour]);
        // Missing: nothing in EnergyPlus reads them.
        for column in column::ILLUMINANCE {
            values[column] = "999999".into();
        }
        values[column::ZENITH_LUMINANCE] = "9999".into();
    }
}

/// The hours of each month.
fn months() -> impl Iterator<Item = Range<usize>> {
    DAYS.iter().scan(0, |start, days| {
        let hours = *start..*start + 24 * days;
        *start = hours.end;
        Some(hours)
    })
}

/// Means, one a day.
fn daily_means(hours: &[f64]) -> Vec<f64> {
    hours.chunks(24).map(mean).collect()
}

/// The slow part of a year: daily means at noon, joined by straight lines, so that stretching it tears nothing at
/// midnight.
fn trend(hours: &[f64]) -> Vec<f64> {
    let means = daily_means(hours);
    let at = |hour: usize| {
        // The middle of the hour, in days after the first noon.
        let days = ((hour as f64 + 0.5) / 24.0 - 0.5).clamp(0.0, (means.len() - 1) as f64);
        let day = (days as usize).min(means.len() - 2);
        means[day] + (days - day as f64) * (means[day + 1] - means[day])
    };
    (0..hours.len()).map(at).collect()
}

/// Standard deviation of the daily means.
fn spread(hours: &[f64]) -> f64 {
    let days = daily_means(hours);
    let mean = mean(&days);
    let squares: f64 = days.iter().map(|day| (day - mean) * (day - mean)).sum();
    (squares / (days.len() - 1) as f64).sqrt()
}

/// Mean over the days of highest less lowest hour.
fn range(hours: &[f64]) -> f64 {
    let range = |day: &[f64]| {
        let (low, high) =
            day.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    hours.chunks(24).map(range).sum::<f64>() / (hours.len() / 24) as f64
}

/// What the hours of a month shall have.
struct Target {
    mean: f64,
    /// Standard deviation of the daily means.
    spread: f64,
    /// Mean daily range.
    range: f64,
}

impl Target {
    /// The hours with their trend and what is off it stretched, and then shifted.
    fn reached_by(&self, hours: &[f64], trend: &[f64]) -> Vec<f64> {
        let (mut slow, mut fast) = (1.0, 1.0);
        let mut stretched = hours.to_vec();
        for _ in 0..PASSES {
            slow *= self.spread / spread(&stretched);
            fast *= self.range / range(&stretched);
            let pairs = hours.iter().zip(trend);
            stretched = pairs.map(|(hour, trend)| slow * trend + fast * (hour - trend)).collect();
        }
        let shift = self.mean - mean(&stretched);
        stretched.iter().map(|hour| hour + shift).collect()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Dew points no higher than the dry bulbs, shifted so that their mean stays where it was.
fn held_under(mut dew_points: Vec<f64>, dry_bulbs: &[f64], target: f64) -> Vec<f64> {
    let mut shift = 0.0;
    let clamped = |shift: f64| dew_points.iter().zip(dry_bulbs).map(move |(d, t)| (d + shift).min(*t));
    for _ in 0..PASSES {
        shift += target - clamped(shift).sum::<f64>() / dry_bulbs.len() as f64;
    }
    let held: Vec<f64> = clamped(shift).collect();
    dew_points.copy_from_slice(&held);
    dew_points
}

fn scaled(values: &[f64], to: f64) -> Vec<f64> {
    let ratio = to / mean(values);
    values.iter().map(|value| value * ratio).collect()
}

/// Standard atmosphere (ASHRAE Fundamentals, psychrometrics).
fn at_elevation(pressures: &[f64], from: f64, to: f64) -> Vec<f64> {
    let standard = |elevation: f64| libm::pow(1.0 - 2.25577e-5 * elevation, 5.2559);
    let ratio = standard(to) / standard(from);
    pressures.iter().map(|pressure| pressure * ratio).collect()
}

fn suns(place: sun::Place) -> Vec<sun::Sun> {
    (0..HOURS as u32).map(|hour| sun::Sun::over(place, hour / 24 + 1, hour % 24 + 1)).collect()
}

/// Global over extraterrestrial of each hour; of its whole day where the sun is low or not up.
fn clearness(global: &[f64], suns: &[sun::Sun]) -> Vec<f64> {
    let of_day = |day: usize| {
        let hours = day * 24..(day + 1) * 24;
        let outside: f64 = suns[hours.clone()].iter().map(sun::Sun::horizontal).sum();
        global[hours].iter().sum::<f64>() / outside
    };
    let of_hour = |hour: usize| match suns[hour].horizontal() {
        outside if outside > LOW_SUN => global[hour] / outside,
        _ => of_day(hour / 24),
    };
    (0..global.len()).map(of_hour).collect()
}

/// Global horizontal of a month whose sum is `target`, no hour clearer than the clearest.
fn with_total(clearness: &[f64], suns: &[sun::Sun], target: f64) -> Vec<f64> {
    let hours = |scale: f64| {
        let pairs = clearness.iter().zip(suns);
        pairs.map(|(k, sun)| (scale * k).min(CLEAREST) * sun.horizontal()).collect::<Vec<f64>>()
    };
    let mut scale = 1.0;
    for _ in 0..PASSES {
        scale *= target / hours(scale).iter().sum::<f64>();
    }
    hours(scale)
}

/// Beam normal and diffuse horizontal, Wh/m².
fn split(global: f64, sun: sun::Sun) -> (f64, f64) {
    let outside = sun.horizontal();
    if outside <= 0.0 {
        return (0.0, 0.0);
    }
    let diffuse = global * sun::diffuse_fraction(global / outside);
    ((global - diffuse) / sun.cosine, diffuse)
}

/// Relative humidity, % (Magnus, coefficients of Alduchov and Eskridge 1996).
fn humidity(dry_bulb: f64, dew_point: f64) -> f64 {
    let exponent = |t: f64| 17.625 * t / (243.04 + t);
    (100.0 * libm::exp(exponent(dew_point) - exponent(dry_bulb))).clamp(0.0, 100.0)
}

/// Long-wave radiation of the sky on a horizontal surface, W/m² (Clark and Allen 1978, Walton 1983, as EnergyPlus).
fn sky_radiation(dry_bulb: f64, dew_point: f64, cover: f64) -> f64 {
    let clear = 0.787 + 0.764 * libm::log((dew_point + 273.15) / 273.0);
    let cloud = 1.0 + cover * (0.0224 + cover * (-0.0035 + cover * 0.00028));
    let kelvin = dry_bulb + 273.15;
    clear * cloud * STEFAN_BOLTZMANN * kelvin * kelvin * kelvin * kelvin
}

fn location(line: &str) -> Result<Location> {
    let fields: Vec<&str> = line.split(',').collect();
    let number = |index: usize| {
        fields.get(index).and_then(|field| field.trim().parse::<f64>().ok()).filter(|value| value.is_finite())
    };
    let (Some(latitude), Some(longitude), Some(time_zone), Some(elevation)) =
        (number(6), number(7), number(8), number(9))
    else {
        return Err(malformed("LOCATION has no latitude, longitude, time zone and elevation"));
    };
    Ok(Location { sun: sun::Place { latitude, longitude, time_zone }, elevation })
}

fn malformed(why: &str) -> Error {
    Error::Malformed { path: "the weather to morph".into(), why: why.into() }
}

fn write_header(text: &mut String, header: &[&str], station: &Station, base_dry_bulb: &[f64]) {
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

/// The ASHRAE fields that are known, at their places in the line.
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

/// Half of the highest less the lowest month.
fn amplitude(months: &[f64]) -> f64 {
    let high = months.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = months.iter().copied().fold(f64::INFINITY, f64::min);
    (high - low) / 2.0
}

#[cfg(test)]
mod tests;
