//! The site of a building, read from the header of its EPW weather file.

use std::path::Path;

use super::clear_sky;
use crate::design_day::DesignDay;
use crate::epw::{Header, Line, Record};
use crate::{EpwFile, Result, ground};

/// The largest difference between the clock and the sun, h; 3.1 in the west of China.
const LATEST_NOON: f64 = 4.0;

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
    /// Monthly mean temperature of undisturbed ground, °C, January first: at the depth in the header nearest to 2 m, or
    /// estimated from the dry bulbs if it has none.
    pub ground_temperatures: [f64; 12],
    /// Monthly mean dry bulb, °C, January first; `None` if a month has no hours in the file.
    pub monthly_dry_bulbs: Option<[f64; 12]>,
    /// The cold design day: 99.6 % dry bulb.
    pub heating: DesignDay,
    /// The hot design day: 0.4 % dry bulb.
    pub cooling: DesignDay,
    /// Year of the rows, if they have one in common, as in a measured year.
    pub year: Option<u32>,
    /// Whether the file has a 29 February and its header says so; otherwise the engine skips it.
    pub has_leap_day: bool,
    /// Whether the file has a 29 February that the engine skips, because its header does not say so.
    pub skips_leap_day: bool,
    /// Whether the header has a period of daylight saving time.
    pub has_daylight_saving: bool,
    /// Number of holidays in the header.
    pub holidays: u32,
    /// Whether the design days were computed from the hours of the file because its header has none.
    pub sized_by_hours: bool,
}

impl Site {
    /// Returns the site in the header of an EPW file.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) when the file cannot be read; the errors of [`Site::from_epw`].
    pub fn read(path: &Path) -> Result<Self> {
        EpwFile::open(path)?.site()
    }

    /// Parses the site from an EPW text; `path` is used in error messages.
    ///
    /// Without design conditions in the header, they are computed from the hours.
    ///
    /// # Errors
    /// [`crate::Error::Malformed`] naming the line and the value when a row is malformed, LOCATION, DESIGN CONDITIONS or
    /// GROUND TEMPERATURES is missing, truncated or not numeric, or the time zone is of another longitude.
    pub fn from_epw(text: &str, path: &Path) -> Result<Self> {
        Self::of(&Header { text, path }, &Record::of(text, path)?)
    }

    pub(crate) fn of(header: &Header, record: &Record) -> Result<Self> {
        let location = header.line("LOCATION")?;
        let design = header.line("DESIGN CONDITIONS")?;
        let sized_by_hours = design.text(1)? == "0";
        let [heating, cooling] = match sized_by_hours {
            true => DesignDay::of_year(record, &design)?,
            false => [
                DesignDay::heating(&design.after("Heating")?)?,
                DesignDay::cooling(&design.after("Cooling")?)?,
            ],
        };
        let [longitude, time_zone] = of_clock(&location)?;
        let optical_depths = clear_sky::optical_depths(location.text(5)?);
        let monthly_dry_bulbs = record.monthly_dry_bulbs();
        let estimated =
            || monthly_dry_bulbs.map_or([record.mean_dry_bulb(); 12], |air| ground::under_air(&air));
        Ok(Self {
            name: location.text(1)?.to_owned(),
            latitude: location.within(6, 90.0)?,
            longitude,
            time_zone,
            elevation: location.number(9)?,
            ground_temperatures: ground::of_header(&header.line("GROUND TEMPERATURES")?)?
                .unwrap_or_else(estimated),
            monthly_dry_bulbs,
            year: record.year(),
            has_leap_day: record.has_leap_day() && observes_leap_days(header),
            skips_leap_day: record.has_leap_day() && !observes_leap_days(header),
            has_daylight_saving: of_calendar(header, 2).is_some_and(|day| day != "0"),
            holidays: of_calendar(header, 4).and_then(|count| count.parse().ok()).unwrap_or(0),
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

/// Returns the longitude (degrees east) and the hours ahead of UTC.
fn of_clock(location: &Line) -> Result<[f64; 2]> {
    let [longitude, time_zone] = [location.within(7, 180.0)?, location.within(8, 14.0)?];
    let noon = (longitude / 15.0 - time_zone + 36.0) % 24.0 - 12.0;
    if noon.abs() <= LATEST_NOON {
        return Ok([longitude, time_zone]);
    }
    Err(location.malformed(format!(
        "longitude {longitude} and time zone {time_zone} are {:.1} h apart, so that the sun would be highest at night; \
         expected degrees east and hours ahead of UTC, both negative in America",
        noon.abs()
    )))
}

/// Returns whether a header says that its file has leap days.
fn observes_leap_days(header: &Header) -> bool {
    of_calendar(header, 1).is_some_and(|given| given.eq_ignore_ascii_case("yes"))
}

/// Returns a field of the line of holidays: leap days, first and last day of daylight saving time, number of holidays.
fn of_calendar<'a>(header: &Header<'a>, index: usize) -> Option<&'a str> {
    header.line("HOLIDAYS/DAYLIGHT SAVINGS").ok()?.text(index).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header of Montréal's CWEC file, shortened.
    const MONTREAL: &str = include_str!("../tests/data/montreal_header.epw");

    /// The header with a line that has no entries.
    fn without(title: &str) -> String {
        let lines = MONTREAL.lines().map(|line| match line.starts_with(title) {
            true => format!("{title},0\n"),
            false => format!("{line}\n"),
        });
        lines.collect()
    }

    /// The rows of a year with a dry bulb by month and hour.
    fn year(dry_bulb: impl Fn(u32, u32) -> i32) -> String {
        let mut text = String::new();
        for (month, days) in (1..).zip(b2b_base::calendar::MONTH_DAYS) {
            for (day, hour) in (1..=days).flat_map(|day| (1..=24).map(move |hour| (day, hour))) {
                let dry_bulb = dry_bulb(month, hour - 1);
                let rest = format!(",{dry_bulb},1,1e5{}", ",1".repeat(25));
                text += &format!("1999,{month},{day},{hour},60,flags,{dry_bulb}{rest}\n");
            }
        }
        text
    }

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
    fn the_header_has_daylight_saving_time_and_holidays() {
        let of = |text: &str| {
            let site = Site::from_epw(text, Path::new("a.epw")).unwrap();
            (site.has_daylight_saving, site.holidays)
        };
        assert_eq!(of(MONTREAL), (false, 0));
        let text = MONTREAL.replace("SAVINGS,No,0,0,0", "SAVINGS,No,3/10,11/3,1,New Year,1/1");
        assert_eq!(of(&text), (true, 1));
    }

    #[test]
    fn a_missing_wind_record_is_not_an_error() {
        let text = MONTREAL.replace(",3.9,260,", ",N/A,N/A,");
        let site = Site::from_epw(&text, Path::new("a.epw")).unwrap();
        assert_eq!(site.heating.wind_speed, None);
    }

    #[test]
    fn missing_design_conditions_are_computed_from_the_hours() {
        let text = without("DESIGN CONDITIONS");
        assert!(why(&text).contains("only 0 hours"), "{}", why(&text));
        let dry_bulb = |month, hour: u32| if month == 1 { -20 } else { 20 + (hour % 12) as i32 };
        let site = Site::from_epw(&(text + &year(dry_bulb)), Path::new("a.epw")).unwrap();
        assert!(site.sized_by_hours);
        assert_eq!((site.heating.month, site.heating.dry_bulb), (1, -20.0));
        assert_eq!((site.cooling.dry_bulb, site.cooling.daily_range), (31.0, 11.0));
    }

    #[test]
    fn ground_without_a_record_has_the_mean_of_the_air() {
        let text = without("GROUND TEMPERATURES") + &year(|_, hour| 10 + (hour % 2) as i32);
        let site = Site::from_epw(&text, Path::new("a.epw")).unwrap();
        assert!(site.ground_temperatures.iter().all(|month| (month - 10.5).abs() < 1e-9));
        let one_depth = "GROUND TEMPERATURES,1,0.5,,,,1,2,3,4,5,6,7,8,9,10,11,12\n";
        let text = text.replace("GROUND TEMPERATURES,0\n", one_depth);
        let site = Site::from_epw(&text, Path::new("a.epw")).unwrap();
        assert_eq!((site.ground_temperatures[0], site.ground_temperatures[11]), (1.0, 12.0));
    }

    #[test]
    fn a_longitude_of_another_time_zone_is_an_error() {
        let west = why(&MONTREAL.replace(",-73.75,", ",73.75,"));
        assert!(west.contains("LOCATION: longitude 73.75 and time zone -5 are 9.9 h apart"), "{west}");
        let date_line = MONTREAL.replace(",-73.75,-5.0,", ",-176.6,12.8,");
        assert_eq!(Site::from_epw(&date_line, Path::new("a.epw")).unwrap().time_zone, 12.8);
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
