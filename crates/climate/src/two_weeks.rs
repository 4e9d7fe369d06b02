//! Two-week periods of a year for operation tasks, chosen from its weather by a rule and named as in BOPTEST.
//!
//! The rule uses daily mean outdoor temperatures. Days below 15 °C count as heating days and days above 18 °C as
//! cooling days; if there are fewer than 14, the 14 coldest or warmest days count. The periods are chosen in this
//! order, each without a day in common with earlier ones:
//!
//! 1. peak heating: the two weeks with the lowest mean temperature;
//! 2. peak cooling: the two weeks with the highest;
//! 3. typical heating: the mean temperature is nearest to the median of the heating days;
//! 4. typical cooling: the mean temperature is nearest to the median of the cooling days;
//! 5. mixed: the mean temperature is nearest to 16.5 °C, halfway between the limits.
//!
//! Of equal periods, the earliest is chosen. The rule does not use seasons, so it is the same in both hemispheres.

use std::fmt;
use std::str::FromStr;

/// Length of each period, days.
pub const TWO_WEEKS: usize = 14;
const DAYS: usize = 365;
/// Daily mean temperature below which a day counts as heating, and above which as cooling, °C.
const LIMITS: [f64; 2] = [15.0, 18.0];

/// A two-week period of a year.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TwoWeeks {
    /// The coldest.
    PeakHeating,
    /// The warmest.
    PeakCooling,
    /// As cold as typical heating days.
    TypicalHeating,
    /// As warm as typical cooling days.
    TypicalCooling,
    /// Neither cold nor warm.
    Mixed,
}

impl TwoWeeks {
    /// All, in the order in which they are chosen.
    pub const ALL: [Self; 5] =
        [Self::PeakHeating, Self::PeakCooling, Self::TypicalHeating, Self::TypicalCooling, Self::Mixed];

    /// Returns the name, for example `peak-heating`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PeakHeating => "peak-heating",
            Self::PeakCooling => "peak-cooling",
            Self::TypicalHeating => "typical-heating",
            Self::TypicalCooling => "typical-cooling",
            Self::Mixed => "mixed",
        }
    }

    /// Returns the first day, from 1, in a year of 8760 hourly outdoor temperatures, °C; `None` for another number of
    /// hours.
    pub fn first_day(self, hourly: &[f64]) -> Option<u32> {
        if hourly.len() != 24 * DAYS {
            return None;
        }
        let days: Vec<f64> = hourly.chunks(24).map(mean).collect();
        let windows: Vec<f64> = days.windows(TWO_WEEKS).map(mean).collect();
        let mut taken: Vec<usize> = Vec::new();
        for each in Self::ALL {
            let wanted = each.wanted(&days);
            let is_free = |first: &usize| taken.iter().all(|other| first.abs_diff(*other) >= TWO_WEEKS);
            let distance = |first: &usize| (windows[*first] - wanted).abs();
            let best =
                (0..windows.len()).filter(is_free).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            if each == self {
                return Some(best as u32 + 1);
            }
            taken.push(best);
        }
        None
    }

    /// Returns the mean temperature that the period should be nearest to.
    fn wanted(self, days: &[f64]) -> f64 {
        match self {
            Self::PeakHeating => -1e3,
            Self::PeakCooling => 1e3,
            Self::TypicalHeating => {
                let mut sorted = days.to_vec();
                sorted.sort_unstable_by(f64::total_cmp);
                let cold = sorted.iter().filter(|day| **day < LIMITS[0]).count().max(TWO_WEEKS);
                sorted[cold / 2]
            }
            Self::TypicalCooling => {
                let mut sorted = days.to_vec();
                sorted.sort_unstable_by(f64::total_cmp);
                let warm = sorted.iter().filter(|day| **day > LIMITS[1]).count().max(TWO_WEEKS);
                sorted[sorted.len() - 1 - warm / 2]
            }
            Self::Mixed => 0.5 * (LIMITS[0] + LIMITS[1]),
        }
    }
}

impl fmt::Display for TwoWeeks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for TwoWeeks {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        Self::ALL.into_iter().find(|each| each.name() == text).ok_or(())
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A year around a mean, °C, with its coldest day on a day of the year.
    fn year(mean: f64, swing: f64, coldest: f64) -> Vec<f64> {
        let hour = |hour: usize| {
            let day = (hour / 24) as f64;
            let season = ((day - coldest) / 365.0 * std::f64::consts::TAU).cos();
            mean - swing * season + 4.0 * (hour as f64 / 24.0 * std::f64::consts::TAU).sin()
        };
        (0..24 * DAYS).map(hour).collect()
    }

    fn first(two_weeks: TwoWeeks, hourly: &[f64]) -> u32 {
        two_weeks.first_day(hourly).unwrap()
    }

    #[test]
    fn peaks_are_around_the_coldest_and_the_warmest_day_of_either_hemisphere() {
        let north = year(10.0, 15.0, 20.0);
        let south = year(10.0, 15.0, 202.0);
        assert!((first(TwoWeeks::PeakHeating, &north) as i32 - 14).abs() <= 1);
        assert!((first(TwoWeeks::PeakCooling, &north) as i32 - 197).abs() <= 1);
        assert!((first(TwoWeeks::PeakHeating, &south) as i32 - 196).abs() <= 1);
        assert!((first(TwoWeeks::PeakCooling, &south) as i32 - 14).abs() <= 1);
    }

    #[test]
    fn the_two_weeks_of_a_year_have_no_day_in_common() {
        for hourly in [year(10.0, 15.0, 20.0), year(24.0, 4.0, 20.0), year(-4.0, 20.0, 20.0)] {
            let mut firsts = TwoWeeks::ALL.map(|each| first(each, &hourly));
            firsts.sort_unstable();
            assert!(firsts.windows(2).all(|pair| pair[1] - pair[0] >= TWO_WEEKS as u32), "{firsts:?}");
            assert!(firsts[0] >= 1 && firsts[4] <= 352, "{firsts:?}");
        }
    }

    #[test]
    fn typical_weeks_are_as_warm_as_the_median_of_their_days() {
        let hourly = year(10.0, 15.0, 20.0);
        let mean_of = |two_weeks| {
            let from = 24 * (first(two_weeks, &hourly) as usize - 1);
            mean(&hourly[from..from + 24 * TWO_WEEKS])
        };
        assert!((mean_of(TwoWeeks::Mixed) - 16.5).abs() < 0.3);
        assert!((0.0..6.0).contains(&mean_of(TwoWeeks::TypicalHeating)));
        assert!((21.0..24.0).contains(&mean_of(TwoWeeks::TypicalCooling)));
        assert_eq!(TwoWeeks::Mixed.first_day(&hourly[..100]), None);
    }

    #[test]
    fn a_name_is_read_back() {
        for each in TwoWeeks::ALL {
            assert_eq!(each.name().parse(), Ok(each));
        }
    }
}
