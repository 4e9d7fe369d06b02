//! Design days of a weather file.

use crate::Result;
use crate::epw::{Line, Record};

/// Hours of a year.
const HOURS: usize = 8760;

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
    /// Mean coincident wet bulb, °C; `None` in winter, when sizing days are saturated, and where the station has no
    /// record.
    pub wet_bulb: Option<f64>,
    /// Optical depths of a clear sky for beam and diffuse irradiance (taub, taud) on the hot design day, where known.
    pub optical_depths: Option<[f64; 2]>,
}

impl DesignDay {
    /// Reads the ASHRAE heating conditions: month, 99.6 % and 99 % dry bulb, ..., wind speed with the 99.6 % dry bulb.
    pub(crate) fn heating(line: &Line) -> Result<Self> {
        Ok(Self {
            month: line.month(0)?,
            dry_bulb: line.within(1, 70.0)?,
            daily_range: 0.0,
            wind_speed: line.number(13).ok(),
            wind_direction: line.number(14).ok(),
            wet_bulb: None,
            optical_depths: None,
        })
    }

    /// Reads the ASHRAE cooling conditions: month, daily range, 0.4 % dry bulb, its wet bulb, ..., wind speed with it.
    pub(crate) fn cooling(line: &Line) -> Result<Self> {
        Ok(Self {
            month: line.month(0)?,
            daily_range: line.within(1, 50.0)?,
            dry_bulb: line.within(2, 70.0)?,
            wind_speed: line.number(14).ok(),
            wind_direction: line.number(15).ok(),
            wet_bulb: line.number(3).ok(),
            optical_depths: None,
        })
    }

    /// Returns the cold and the hot design day of a file whose header has none: the 99.6 % and 0.4 % dry bulbs of its
    /// hours, as ASHRAE defines them, without wind.
    pub(crate) fn of_year(record: &Record, line: &Line) -> Result<[Self; 2]> {
        let hours = record.hours().iter();
        let mut hours: Vec<(f64, u32)> = hours.map(|hour| (hour.dry_bulb, hour.month as u32 + 1)).collect();
        if hours.len() < HOURS {
            let why = format!("none given, and only {} hours to compute them from", hours.len());
            return Err(line.malformed(why));
        }
        let daily_range = |month| mean_daily_range(&hours, month);
        let ranges: Vec<f64> = (1..=12).map(daily_range).collect();
        hours.sort_by(|a, b| a.0.total_cmp(&b.0));
        let exceeded = |fraction: f64| hours[(fraction * (hours.len() - 1) as f64) as usize];
        let day = |(dry_bulb, month): (f64, u32), daily_range| Self {
            month,
            dry_bulb,
            daily_range,
            wind_speed: None,
            wind_direction: None,
            wet_bulb: None,
            optical_depths: None,
        };
        let (cold, hot) = (exceeded(0.004), exceeded(0.996));
        Ok([day(cold, 0.0), day(hot, ranges[hot.1 as usize - 1])])
    }
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
