//! The site of a building, read from the header of its EPW weather file.

use std::path::Path;

use super::clear_sky;
use crate::{EpwFile, Error, Result};

/// Depth of the ground temperatures at a foundation, m: the middle set of an EPW header, about the depth of a basement
/// floor.
const GROUND_DEPTH: f64 = 2.0;
/// Fields of one depth in GROUND TEMPERATURES: depth, conductivity, density, specific heat, 12 months.
const GROUND_FIELDS: usize = 16;

/// A site: its location, its ground temperatures and its design days.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Name of the station.
    pub name: String,
    /// Degrees north.
    pub latitude: f64,
    /// Degrees east.
    pub longitude: f64,
    /// Hours ahead of UTC.
    pub time_zone: f64,
    /// Elevation above sea level, m.
    pub elevation: f64,
    /// Monthly mean temperature of undisturbed ground at 2 m, °C, January first.
    pub ground_temperatures: [f64; 12],
    /// Monthly mean dry bulb, °C, January first; `None` if a month has no hours in the file.
    pub monthly_dry_bulbs: Option<[f64; 12]>,
    /// The cold design day: 99.6 % dry bulb.
    pub heating: DesignDay,
    /// The hot design day: 0.4 % dry bulb.
    pub cooling: DesignDay,
    /// Whether the design days were computed from the hours of the file because its header has none.
    pub sized_by_hours: bool,
}

/// A design day: the weather that equipment is sized for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignDay {
    /// Month, 1 to 12.
    pub month: u32,
    /// Extreme dry bulb of the day, °C.
    pub dry_bulb: f64,
    /// Difference between the day's highest and lowest dry bulb, K; 0 in winter, as sizing days are flat.
    pub daily_range: f64,
    /// Mean coincident wind speed at 10 m, m/s; `None` where the station has no record.
    pub wind_speed: Option<f64>,
    /// Direction of this wind, degrees clockwise from north; `None` where the station has no record.
    pub wind_direction: Option<f64>,
    /// Mean wet bulb with the extreme dry bulb, °C; `None` in winter, when sizing days are saturated, and where the
    /// station has no record.
    pub wet_bulb: Option<f64>,
    /// Optical depths of a clear sky for beam and diffuse irradiance (taub, taud) on the hot design day, where known.
    pub optical_depths: Option<[f64; 2]>,
}

impl Site {
    /// Returns the site in the header of an EPW file.
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read; the errors of [`Site::from_epw`].
    pub fn read(path: &Path) -> Result<Self> {
        EpwFile::open(path)?.site()
    }

    /// Parses the site from an EPW text; `path` is used in error messages.
    ///
    /// Without design conditions in the header, they are computed from the hours.
    ///
    /// # Errors
    /// [`Error::Malformed`] naming the header line and the value when LOCATION, DESIGN CONDITIONS or
    /// GROUND TEMPERATURES is missing, truncated or not numeric.
    pub fn from_epw(text: &str, path: &Path) -> Result<Self> {
        let header = Header { text, path };
        let location = header.line("LOCATION")?;
        let design = header.line("DESIGN CONDITIONS")?;
        let sized_by_hours = design.text(1)? == "0";
        let (heating, cooling) = match sized_by_hours {
            true => design_days_of_year(text, &design)?,
            false => (design.after("Heating")?.heating()?, design.after("Cooling")?.cooling()?),
        };
        let optical_depths = clear_sky::optical_depths(location.text(5)?);
        Ok(Self {
            name: location.text(1)?.to_owned(),
            latitude: location.within(6, 90.0)?,
            longitude: location.within(7, 180.0)?,
            time_zone: location.within(8, 14.0)?,
            elevation: location.number(9)?,
            ground_temperatures: ground_temperatures(&header.line("GROUND TEMPERATURES")?)?,
            monthly_dry_bulbs: monthly_dry_bulbs(text),
            heating,
            cooling: DesignDay { optical_depths, ..cooling },
            sized_by_hours,
        })
    }

    /// Standard barometric pressure at the elevation of the site, Pa (standard atmosphere, as in EnergyPlus).
    pub fn pressure(&self) -> f64 {
        101_325.0 * libm::pow(1.0 - 2.25577e-05 * self.elevation, 5.2559)
    }
}

/// The header of an EPW file.
struct Header<'a> {
    text: &'a str,
    path: &'a Path,
}

impl<'a> Header<'a> {
    fn line(&self, title: &'a str) -> Result<Line<'a>> {
        let line = |text: &'a str| Line {
            title,
            fields: text.split(',').map(str::trim).collect(),
            path: self.path.to_owned(),
        };
        self.text
            .lines()
            .take(8)
            .map(line)
            .find(|line| line.fields[0].eq_ignore_ascii_case(title))
            .ok_or_else(|| Error::Malformed {
                path: self.path.to_owned(),
                why: format!("no {title} line: not an EPW file, or truncated"),
            })
    }
}

/// The fields of one header line, or of a part of it.
struct Line<'a> {
    title: &'a str,
    fields: Vec<&'a str>,
    path: std::path::PathBuf,
}

impl<'a> Line<'a> {
    fn malformed(&self, why: String) -> Error {
        Error::Malformed { path: self.path.clone(), why: format!("{}: {why}", self.title) }
    }

    fn text(&self, index: usize) -> Result<&'a str> {
        self.fields
            .get(index)
            .copied()
            .ok_or_else(|| self.malformed(format!("truncated: no field {}", index + 1)))
    }

    fn number(&self, index: usize) -> Result<f64> {
        let text = self.text(index)?;
        text.parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| self.malformed(format!("field {} is `{text}`; expected a number", index + 1)))
    }

    fn within(&self, index: usize, bound: f64) -> Result<f64> {
        let value = self.number(index)?;
        if value.abs() <= bound {
            Ok(value)
        } else {
            Err(self.malformed(format!("field {} is {value}; expected a number within ±{bound}", index + 1)))
        }
    }

    fn month(&self, index: usize) -> Result<u32> {
        let text = self.text(index)?;
        text.parse()
            .ok()
            .filter(|month| (1..=12).contains(month))
            .ok_or_else(|| self.malformed(format!("`{text}` is not a month from 1 to 12")))
    }

    /// The fields that follow a word in the line.
    fn after(&self, word: &str) -> Result<Self> {
        let start = self
            .fields
            .iter()
            .position(|field| field.eq_ignore_ascii_case(word))
            .ok_or_else(|| self.malformed(format!("no {word} part")))?;
        Ok(Self { title: self.title, fields: self.fields[start + 1..].to_vec(), path: self.path.clone() })
    }

    /// ASHRAE heating conditions: month, 99.6 % and 99 % dry bulb, ..., wind speed with the 99.6 % dry bulb.
    fn heating(&self) -> Result<DesignDay> {
        Ok(DesignDay {
            month: self.month(0)?,
            dry_bulb: self.within(1, 70.0)?,
            daily_range: 0.0,
            wind_speed: self.number(13).ok(),
            wind_direction: self.number(14).ok(),
            wet_bulb: None,
            optical_depths: None,
        })
    }

    /// ASHRAE cooling conditions: month, daily range, 0.4 % dry bulb, its wet bulb, ..., wind speed with it.
    fn cooling(&self) -> Result<DesignDay> {
        Ok(DesignDay {
            month: self.month(0)?,
            daily_range: self.within(1, 50.0)?,
            dry_bulb: self.within(2, 70.0)?,
            wind_speed: self.number(14).ok(),
            wind_direction: self.number(15).ok(),
            wet_bulb: self.number(3).ok(),
            optical_depths: None,
        })
    }
}

/// Design days of a file whose header has none: the 99.6 % and 0.4 % dry bulbs of its hours, as ASHRAE defines them,
/// without wind.
fn design_days_of_year(text: &str, line: &Line) -> Result<(DesignDay, DesignDay)> {
    let mut hours: Vec<(f64, u32)> = text.lines().skip(8).filter_map(month_and_dry_bulb).collect();
    if hours.len() < 8760 {
        let why = format!("none given, and only {} hours to compute them from", hours.len());
        return Err(line.malformed(why));
    }
    let daily_range = |month| mean_daily_range(&hours, month);
    let ranges: Vec<f64> = (1..=12).map(daily_range).collect();
    hours.sort_by(|a, b| a.0.total_cmp(&b.0));
    let exceeded = |fraction: f64| hours[(fraction * (hours.len() - 1) as f64) as usize];
    let day = |(dry_bulb, month): (f64, u32), daily_range| DesignDay {
        month,
        dry_bulb,
        daily_range,
        wind_speed: None,
        wind_direction: None,
        wet_bulb: None,
        optical_depths: None,
    };
    let (cold, hot) = (exceeded(0.004), exceeded(0.996));
    Ok((day(cold, 0.0), day(hot, ranges[hot.1 as usize - 1])))
}

/// Monthly mean dry bulbs; `None` if a month has no hours.
fn monthly_dry_bulbs(text: &str) -> Option<[f64; 12]> {
    let (mut sums, mut counts) = ([0.0; 12], [0.0; 12]);
    for (dry_bulb, month) in text.lines().skip(8).filter_map(month_and_dry_bulb) {
        sums[month as usize - 1] += dry_bulb;
        counts[month as usize - 1] += 1.0;
    }
    let means = std::array::from_fn(|month| sums[month] / counts[month]);
    means.iter().all(|mean: &f64| mean.is_finite()).then_some(means)
}

pub(super) fn month_and_dry_bulb(hour: &str) -> Option<(f64, u32)> {
    let mut fields = hour.split(',').map(str::trim);
    let month = fields.nth(1)?.parse().ok()?;
    let dry_bulb: f64 = fields.nth(4)?.parse().ok()?;
    (dry_bulb.is_finite() && (1..=12).contains(&month)).then_some((dry_bulb, month))
}

/// Mean daily range of a month, K: highest less lowest hour of each day.
fn mean_daily_range(hours: &[(f64, u32)], month: u32) -> f64 {
    let ranges: Vec<f64> = hours
        .chunks(24)
        .filter(|day| day[0].1 == month)
        .map(|day| {
            let (low, high) =
                day.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d.0), h.max(d.0)));
            high - low
        })
        .collect();
    ranges.iter().sum::<f64>() / ranges.len().max(1) as f64
}

fn ground_temperatures(line: &Line) -> Result<[f64; 12]> {
    let depths = line.number(1)? as usize;
    for depth in 0..depths {
        let start = 2 + depth * GROUND_FIELDS;
        if (line.number(start)? - GROUND_DEPTH).abs() < 0.05 {
            let mut months = [0.0; 12];
            for (month, temperature) in months.iter_mut().enumerate() {
                *temperature = line.within(start + 4 + month, 70.0)?;
            }
            return Ok(months);
        }
    }
    Err(line.malformed(format!("no temperatures at {GROUND_DEPTH} m")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header of Montréal's CWEC file, shortened.
    const MONTREAL: &str = include_str!("../tests/data/montreal_header.epw");

    fn why(text: &str) -> String {
        Site::from_epw(text, Path::new("a.epw")).unwrap_err().to_string()
    }

    #[test]
    fn the_header_has_the_site_its_ground_and_its_design_days() {
        let site = Site::from_epw(MONTREAL, Path::new("a.epw")).unwrap();
        assert_eq!((site.latitude, site.longitude, site.elevation), (45.47, -73.75, 36.0));
        assert_eq!(site.ground_temperatures[0], 2.71);
        assert_eq!(site.ground_temperatures[11], 8.08);
        assert_eq!((site.heating.dry_bulb, site.heating.wind_speed), (-23.7, Some(3.9)));
        assert_eq!((site.cooling.dry_bulb, site.cooling.daily_range), (30.0, 9.3));
        assert!(!site.sized_by_hours);
    }

    #[test]
    fn a_missing_wind_record_is_not_an_error() {
        let text = MONTREAL.replace(",3.9,260,", ",N/A,N/A,");
        let site = Site::from_epw(&text, Path::new("a.epw")).unwrap();
        assert_eq!(site.heating.wind_speed, None);
    }

    #[test]
    fn missing_design_conditions_are_computed_from_the_hours() {
        let (before, after) = MONTREAL.split_once("DESIGN CONDITIONS").unwrap();
        let (_, after) = after.split_once('\n').unwrap();
        let mut text = format!("{before}DESIGN CONDITIONS,0\n{after}");
        assert!(why(&text).contains("only 0 hours"), "{}", why(&text));
        for hour in 0..8760 {
            let month = 1 + (hour / 24) / 31;
            let dry_bulb = if month == 1 { -20 } else { 20 + hour % 24 % 12 };
            text += &format!("1999,{month},1,1,60,flags,{dry_bulb}\n");
        }
        let site = Site::from_epw(&text, Path::new("a.epw")).unwrap();
        assert!(site.sized_by_hours);
        assert_eq!((site.heating.month, site.heating.dry_bulb), (1, -20.0));
        assert_eq!((site.cooling.dry_bulb, site.cooling.daily_range), (31.0, 11.0));
    }

    #[test]
    fn the_error_of_a_truncated_header_names_the_line() {
        assert!(why("").contains("no LOCATION line"));
        let text = MONTREAL.replace(",45.47,-73.75,-5.0,36.0", "");
        assert!(why(&text).contains("LOCATION: truncated"));
        let text = MONTREAL.replace(",Cooling,", ",");
        assert!(why(&text).contains("DESIGN CONDITIONS: no Cooling part"));
        let text = MONTREAL.replace(",12.81,8.08", "");
        assert!(why(&text).contains("GROUND TEMPERATURES: truncated"));
        let text = MONTREAL.replace("45.47", "north");
        assert!(why(&text).contains("`north`"));
    }
}
