//! The ASHRAE 169 climate zone of a weather file.

use std::fmt;

use super::DegreeDays;
use crate::epw::{Record, mean};

/// Mean relative humidity below which a climate is dry, %.
const DRY: f64 = 60.0;

/// The statistics of a year of weather that determine its climate zone.
///
/// The thermal digit follows ANSI/ASHRAE Standard 169, by degree-days. The standard's letters depend on yearly
/// precipitation, which weather files rarely have: here a climate is dry (B) if the mean relative humidity is below
/// 60 %, marine (C) if it is in zones 3 to 5 and the standard's three conditions on monthly means hold, and humid (A)
/// otherwise. With this rule the 19 known places have the zones of the standard. A typical year can differ from the
/// standard's own table by county: Las Vegas is 3B there and 2B by its TMY3 file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClimateYear {
    /// Heating degree-days below 18 °C, K·d.
    pub heating_degree_days: f64,
    /// Cooling degree-days above 10 °C, K·d.
    pub cooling_degree_days: f64,
    /// Mean dry bulb of each month, °C.
    pub monthly_dry_bulbs: [f64; 12],
    /// Mean relative humidity, %.
    pub relative_humidity: f64,
}

impl ClimateYear {
    /// Computes the statistics of the hours of a file; `None` if a day of the year is missing.
    pub(crate) fn of(record: &Record) -> Option<Self> {
        let monthly_dry_bulbs = record.monthly_dry_bulbs()?;
        let days = DegreeDays::of(record);
        record.is_whole_year().then(|| Self {
            heating_degree_days: days.heating,
            cooling_degree_days: days.cooling,
            monthly_dry_bulbs,
            relative_humidity: mean(record.hours().iter().map(|hour| hour.relative_humidity)),
        })
    }

    /// Returns the climate zone, for example `5B` or `7`.
    pub fn zone(&self) -> String {
        match self.thermal_zone() {
            cold @ 7.. => cold.to_string(),
            zone => format!("{zone}{}", self.moisture(zone)),
        }
    }

    /// The thermal zone, 0 to 8 (ASHRAE 169-2020, table A-3).
    fn thermal_zone(&self) -> u32 {
        let (heat, cool) = (self.heating_degree_days, self.cooling_degree_days);
        const COOLING: [f64; 3] = [6000.0, 5000.0, 3500.0];
        const HEATING: [f64; 5] = [2000.0, 3000.0, 4000.0, 5000.0, 7000.0];
        let hot = COOLING.iter().position(|limit| cool > *limit);
        let cold = || HEATING.iter().take_while(|limit| heat > **limit).count() + COOLING.len();
        hot.unwrap_or_else(cold) as u32
    }

    fn moisture(&self, thermal_zone: u32) -> char {
        if self.relative_humidity < DRY {
            'B'
        } else if (3..=5).contains(&thermal_zone) && self.marine() {
            'C'
        } else {
            'A'
        }
    }

    /// Returns whether the coldest month is between -3 and 18 °C, the warmest below 22 °C, and four months above 10 °C.
    fn marine(&self) -> bool {
        let months = self.monthly_dry_bulbs;
        let coldest = months.iter().copied().fold(f64::INFINITY, f64::min);
        let warmest = months.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mild = months.iter().filter(|month| **month > 10.0).count();
        (-3.0..=18.0).contains(&coldest) && warmest < 22.0 && mild >= 4
    }
}

impl fmt::Display for ClimateYear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.0} K·d below 18 °C, {:.0} K·d above 10 °C, mean relative humidity {:.0} %",
            self.heating_degree_days, self.cooling_degree_days, self.relative_humidity
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::{EpwFile, PLACES};
    use b2b_energyplus::install::Quiet;

    /// Uses the user's own cache, and fills it when it is empty.
    #[test]
    fn the_zone_of_every_place_follows_from_its_weather_file() {
        for place in &PLACES {
            let file = EpwFile::open(&place.epw(&mut Quiet).unwrap()).unwrap();
            let year = file.year().unwrap().unwrap();
            assert_eq!(year.zone(), place.ashrae_zone, "{}: {year}", place.name);
        }
    }
}
