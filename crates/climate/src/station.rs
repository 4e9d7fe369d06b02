//! The monthly normals of 17 Québec stations.

use std::sync::LazyLock;

/// One row per station and month: means over the station's CWEC year.
const MONTHLY: &str = include_str!("../data/quebec_monthly_climate.csv");
/// One row per station with ASHRAE design conditions in its CWEC file.
const DESIGN: &str = include_str!("../data/quebec_design_days.csv");

/// Days of each month.
const DAYS: [f64; 12] = [31.0, 28.0, 31.0, 30.0, 31.0, 30.0, 31.0, 31.0, 30.0, 31.0, 30.0, 31.0];
/// Base temperature of heating degree-days, °C.
const DEGREE_DAY_BASE: f64 = 18.0;

/// A weather station and its climate.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// Name of its CWEC file, without extension.
    pub name: &'static str,
    /// Degrees north.
    pub latitude: f64,
    /// Degrees east.
    pub longitude: f64,
    /// Elevation above sea level, m.
    pub elevation: f64,
    /// Number at the World Meteorological Organization; 999999 if it has none.
    pub wmo: &'static str,
    /// Normals of each month, January first.
    pub months: [MonthNormals; 12],
    /// Design conditions, if a handbook publishes them.
    pub design: Option<DesignConditions>,
}

/// Normals of a month.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MonthNormals {
    /// Dry bulb, °C.
    pub dry_bulb: f64,
    /// Mean daily range of dry bulb, K.
    pub daily_range: f64,
    /// Standard deviation of the daily mean dry bulb, K.
    pub daily_spread: f64,
    /// Dew point, °C.
    pub dew_point: f64,
    /// Wind speed, m/s.
    pub wind_speed: f64,
    /// Global horizontal irradiation, Wh/m² per day.
    pub global_horizontal: f64,
}

/// ASHRAE design conditions as they appear in an EPW header; `N/A` where the station has no record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DesignConditions {
    /// The edition that publishes them.
    pub edition: &'static str,
    /// Coldest month.
    pub heating_month: &'static str,
    /// Dry bulb exceeded 99.6 % of the year, °C.
    pub heating_dry_bulb: &'static str,
    /// Wind with it, m/s and degrees.
    pub heating_wind: [&'static str; 2],
    /// Hottest month.
    pub cooling_month: &'static str,
    /// Daily range of dry bulb in it, K.
    pub cooling_range: &'static str,
    /// Dry bulb exceeded 0.4 % of the year, and the wet bulb with it, °C.
    pub cooling_bulbs: [&'static str; 2],
    /// Wind with them, m/s and degrees.
    pub cooling_wind: [&'static str; 2],
}

impl MonthNormals {
    /// Expected shortfall of a daily mean below a temperature, K.
    fn mean_below(&self, temperature: f64) -> f64 {
        let z = (temperature - self.dry_bulb) / self.daily_spread;
        let probability = 0.5 * (1.0 + libm::erf(z * std::f64::consts::FRAC_1_SQRT_2));
        let density = libm::exp(-0.5 * z * z) / libm::sqrt(2.0 * std::f64::consts::PI);
        self.daily_spread * (z * probability + density)
    }
}

impl Station {
    /// Returns every station, in the order of the data file.
    pub fn all() -> &'static [Self] {
        static STATIONS: LazyLock<Vec<Station>> = LazyLock::new(read);
        &STATIONS
    }

    /// Returns the heating degree-days below 18 °C of a typical year, K·d, computed from the normals with normally
    /// distributed daily means.
    pub fn heating_degree_days(&self) -> f64 {
        self.months.iter().zip(DAYS).map(|(month, days)| days * month.mean_below(DEGREE_DAY_BASE)).sum()
    }

    /// Returns the station with this name.
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::all().iter().find(|station| station.name == name)
    }
}

/// The rows of an embedded table, without its title row.
pub(super) fn rows(table: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    table.lines().skip(1).map(|line| line.split(',').collect())
}

fn read() -> Vec<Station> {
    let rows: Vec<_> = rows(MONTHLY).collect();
    rows.chunks(12).map(station).collect()
}

fn station(rows: &[Vec<&'static str>]) -> Station {
    let name = rows[0][0];
    let [latitude, longitude, elevation] = [1, 2, 3].map(|column| number(&rows[0], column));
    Station {
        name,
        latitude,
        longitude,
        elevation,
        wmo: rows[0][4],
        months: std::array::from_fn(|month| normals(&rows[month])),
        design: design(name),
    }
}

/// Columns: station, lat, lon, elev, wmo, month, DBmax, DBmin, DBmean, DBstd_daily, lag1, DPmean, RHmean, wind, GHI,
/// DNI, DHI.
fn normals(row: &[&str]) -> MonthNormals {
    MonthNormals {
        dry_bulb: number(row, 8),
        daily_range: number(row, 6) - number(row, 7),
        daily_spread: number(row, 9),
        dew_point: number(row, 11),
        wind_speed: number(row, 13),
        global_horizontal: 1000.0 * number(row, 14),
    }
}

/// Columns: station, wmo, edition, htg_month, htg_DB99.6, htg_WS, htg_WD, clg_month, clg_DR, clg_DB0.4, clg_MCWB,
/// clg_WS, clg_WD, pressure_Pa.
fn design(station: &str) -> Option<DesignConditions> {
    let row = rows(DESIGN).find(|row| row[0] == station)?;
    Some(DesignConditions {
        edition: row[2],
        heating_month: row[3],
        heating_dry_bulb: row[4],
        heating_wind: [row[5], row[6]],
        cooling_month: row[7],
        cooling_range: row[8],
        cooling_bulbs: [row[9], row[10]],
        cooling_wind: [row[11], row[12]],
    })
}

/// A number of an embedded table; a test parses the whole table.
fn number(row: &[&str], column: usize) -> f64 {
    row[column].parse().expect("the embedded table holds numbers")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seventeen_stations_have_twelve_months_each() {
        assert_eq!(Station::all().len(), 17);
        for row in rows(MONTHLY).collect::<Vec<_>>().chunks(12) {
            let months: Vec<u32> = row.iter().map(|row| row[5].parse().unwrap()).collect();
            assert_eq!(months, (1..=12).collect::<Vec<_>>(), "{}", row[0][0]);
            assert!(row.iter().all(|r| r[0] == row[0][0]));
        }
    }

    /// Computed by hand for months far from the base, where the spread does not matter; the National Building Code of
    /// Canada (table C-2) has 4400 for Montréal-Dorval.
    #[test]
    fn degree_days_sum_shortfalls_below_the_base() {
        let month = |dry_bulb| MonthNormals { dry_bulb, daily_spread: 2.0, ..MonthNormals::default() };
        assert!((month(-12.0).mean_below(18.0) - 30.0).abs() < 1e-9);
        assert!(month(48.0).mean_below(18.0).abs() < 1e-9);
        let montreal = Station::find("CAN_PQ_Montreal.Intl.AP.716270_CWEC").unwrap().heating_degree_days();
        assert!((4200.0..4800.0).contains(&montreal), "{montreal}");
    }

    #[test]
    fn every_design_condition_belongs_to_a_station() {
        for row in rows(DESIGN) {
            assert!(Station::find(row[0]).is_some_and(|station| station.design.is_some()), "{}", row[0]);
        }
    }
}
