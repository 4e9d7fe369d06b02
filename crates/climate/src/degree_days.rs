//! Degree-days of a weather file.

use crate::epw::Record;

/// Base temperature of heating degree-days, °C.
const HEATING_BASE: f64 = 18.0;
/// Base temperature of cooling degree-days, °C (ASHRAE 169).
const COOLING_BASE: f64 = 10.0;

/// Degree-days of a year, K·d, from daily means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DegreeDays {
    /// Heating degree-days below 18 °C.
    pub heating: f64,
    /// Cooling degree-days above 10 °C.
    pub cooling: f64,
}

impl DegreeDays {
    /// Computes the degree-days of the hours of a file.
    pub(crate) fn of(record: &Record) -> Self {
        Self::of_hours(&record.hours().iter().map(|hour| hour.dry_bulb).collect::<Vec<_>>())
    }

    /// Degree-days of hourly dry bulbs, °C.
    fn of_hours(dry_bulbs: &[f64]) -> Self {
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
