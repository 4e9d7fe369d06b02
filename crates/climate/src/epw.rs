//! Validation of EPW weather files.
//!
//! On a truncated file EnergyPlus stops in the middle of a run, far from the cause. The check reports the cause before
//! the engine reads the file.

use std::path::Path;

use crate::{Error, Result};

/// Header lines before the first hour.
const HEADER_LINES: usize = 8;
/// Columns of an hour that EnergyPlus reads.
const COLUMNS: usize = 35;
/// The column of source and uncertainty flags, the only text column.
const FLAGS: usize = 5;
/// Column of the dry-bulb temperature.
const DRY_BULB: usize = 6;
/// Column of the global horizontal radiation.
const GLOBAL_RADIATION: usize = 13;
/// Plausible values: column, quantity, limits, and the placeholder for a missing value. The limits are beyond the
/// records on Earth.
const LIMITS: [(usize, &str, [f64; 2], f64); 4] = [
    (DRY_BULB, "dry-bulb temperature (°C)", [-90.0, 60.0], 99.9),
    (7, "dew point (°C)", [-100.0, 60.0], 99.9),
    (8, "relative humidity (%)", [0.0, 110.0], 999.0),
    (21, "wind speed (m/s)", [0.0, 115.0], 999.0),
];
/// Hours of a common and a leap year.
const HOURS: [usize; 2] = [8760, 8784];

/// Checks that an EPW text holds a whole year, and returns its number of hours (8760 or 8784).
///
/// # Errors
/// [`Error::Malformed`] naming the line when an hour has fewer than 35 columns, or a value that is not a finite number or
/// not plausible, or when hours are missing.
pub fn check(text: &str, path: &Path) -> Result<usize> {
    let malformed = |why| Error::Malformed { path: path.to_owned(), why };
    let hint = if text.starts_with("LOCATION") { "" } else { "; an EPW file begins with LOCATION" };
    let mut hours = 0;
    for (index, line) in text.lines().enumerate().skip(HEADER_LINES) {
        if line.trim().is_empty() {
            continue;
        }
        check_hour(line).map_err(|why| malformed(format!("line {}: {why}{hint}", index + 1)))?;
        hours += 1;
    }
    if HOURS.contains(&hours) {
        Ok(hours)
    } else {
        Err(malformed(format!(
            "{hours} hours of weather instead of 8760 (or 8784): the file is truncated or does not cover a whole year"
        )))
    }
}

/// Returns the dry-bulb temperatures at the end of each hour of a year without 29 February, °C, of an EPW text that
/// [`check`] accepts.
pub fn dry_bulbs(text: &str) -> Vec<f64> {
    column(text, DRY_BULB)
}

/// Returns the mean global horizontal radiation of each hour of a year without 29 February, W/m², of an EPW text that
/// [`check`] accepts.
pub fn global_radiation(text: &str) -> Vec<f64> {
    column(text, GLOBAL_RADIATION)
}

/// Returns the values of a column beyond the first three, without 29 February.
fn column(text: &str, column: usize) -> Vec<f64> {
    let hour = |line: &str| {
        let mut columns = line.split(',');
        let [_, month, day] = std::array::from_fn(|_| columns.next().unwrap_or_default().trim());
        let is_leap_day = month.parse() == Ok(2) && day.parse() == Ok(29);
        let value = columns.nth(column - 3)?.trim().parse().ok();
        value.filter(|_| !is_leap_day)
    };
    text.lines().skip(HEADER_LINES).filter_map(hour).collect()
}

fn check_hour(line: &str) -> std::result::Result<(), String> {
    let mut columns = 0;
    for (index, value) in line.split(',').take(COLUMNS).enumerate() {
        columns += 1;
        let finite = value.trim().parse::<f64>().is_ok_and(f64::is_finite);
        if index != FLAGS && !finite {
            return Err(format!("column {} is `{value}`, not a finite number", index + 1));
        }
        check_value(index, value)?;
    }
    if columns < COLUMNS {
        return Err(format!("{columns} columns instead of {COLUMNS}"));
    }
    Ok(())
}

/// Checks that a value is plausible.
fn check_value(column: usize, text: &str) -> std::result::Result<(), String> {
    let Some((_, quantity, [low, high], missing)) = LIMITS.iter().find(|(limited, ..)| *limited == column)
    else {
        return Ok(());
    };
    match text.trim().parse::<f64>() {
        Ok(value) if value != *missing && !(*low..=*high).contains(&value) => {
            Err(format!("the {quantity} is {value}; expected {low} to {high}, or {missing} if it is missing"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn year(hours: usize) -> String {
        let hour = format!("1999,1,1,1,60,flags{}\n", ",1.5".repeat(29));
        "header\n".repeat(HEADER_LINES) + &hour.repeat(hours)
    }

    fn why(text: &str) -> String {
        check(text, Path::new("a.epw")).unwrap_err().to_string()
    }

    #[test]
    fn the_dry_bulbs_of_a_leap_year_leave_out_its_leap_day() {
        let hour =
            |month: u32, day: u32, dry_bulb: f64| format!("1996,{month},{day},1,60,flags,{dry_bulb},1.0\n");
        let text =
            "header\n".repeat(HEADER_LINES) + &hour(2, 28, -3.5) + &hour(2, 29, 7.0) + &hour(3, 1, 4.0);
        assert_eq!(dry_bulbs(&text), [-3.5, 4.0]);
    }

    #[test]
    fn common_and_leap_years_are_complete() {
        for hours in HOURS {
            assert_eq!(check(&year(hours), Path::new("a.epw")).unwrap(), hours);
        }
    }

    #[test]
    fn the_error_of_a_truncated_file_has_its_number_of_hours() {
        let why = why(&year(5000));
        assert!(why.contains("a.epw") && why.contains("5000"), "{why}");
    }

    #[test]
    fn the_error_of_a_truncated_line_or_a_nan_has_its_line() {
        let mut text = year(8760);
        text.truncate(text.len() - 20);
        assert!(why(&text).contains("line 8768"), "{}", why(&text));
        let text = year(8760).replacen("1.5", "nan", 1);
        assert!(why(&text).contains("line 9: column 7"), "{}", why(&text));
        assert!(why(&text).ends_with("an EPW file begins with LOCATION"), "{}", why(&text));
    }

    #[test]
    fn a_value_that_is_not_plausible_is_an_error_with_its_line_and_limits() {
        let hot = year(8760).replacen(",1.5", ",300", 1);
        assert!(why(&hot).contains("line 9: the dry-bulb temperature (°C) is 300; expected -90 to 60"));
        let missing = year(8760).replacen(",1.5", ",99.9", 1);
        assert_eq!(check(&missing, Path::new("a.epw")).unwrap(), 8760);
    }
}
