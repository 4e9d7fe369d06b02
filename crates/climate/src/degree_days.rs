//! Degree-days of a weather file.

use super::site::month_and_dry_bulb;

/// Base temperature of heating degree-days, °C.
const HEATING_BASE: f64 = 18.0;
/// Base temperature of cooling degree-days, °C (ASHRAE 169).
const COOLING_BASE: f64 = 10.0;
/// Header lines of an EPW file.
const HEADER_LINES: usize = 8;

/// Degree-days of a year, K·d, from daily means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DegreeDays {
    /// Heating degree-days below 18 °C.
    pub heating: f64,
    /// Cooling degree-days above 10 °C.
    pub cooling: f64,
}

impl DegreeDays {
    /// Computes the degree-days of an EPW text.
    pub fn from_epw(text: &str) -> Self {
        let hours = text.lines().skip(HEADER_LINES).filter_map(month_and_dry_bulb);
        let hours: Vec<f64> = hours.map(|(dry_bulb, _)| dry_bulb).collect();
        Self::of_hours(&hours)
    }

    /// Degree-days of hourly dry bulbs, °C.
    pub(super) fn of_hours(dry_bulbs: &[f64]) -> Self {
        let mut sum = Self::default();
        for day in dry_bulbs.chunks(24) {
            let mean = day.iter().sum::<f64>() / day.len() as f64;
            sum.heating += (HEATING_BASE - mean).max(0.0);
            sum.cooling += (mean - COOLING_BASE).max(0.0);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degree_days_use_daily_means() {
        let mut hours = [[8.0; 12], [12.0; 12]].concat();
        hours.extend([25.0; 24]);
        assert_eq!(DegreeDays::of_hours(&hours), DegreeDays { heating: 8.0, cooling: 15.0 });
    }
}
