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
/// Hours of a common and a leap year.
const HOURS: [usize; 2] = [8760, 8784];

/// Checks that an EPW text holds a whole year, and returns its number of hours (8760 or 8784).
///
/// # Errors
/// [`Error::Malformed`] naming the line when an hour has fewer than 35 columns or a value that is not a finite
/// number, or when hours are missing.
pub fn check(text: &str, path: &Path) -> Result<usize> {
    let malformed = |why| Error::Malformed { path: path.to_owned(), why };
    let mut hours = 0;
    for (index, line) in text.lines().enumerate().skip(HEADER_LINES) {
        if line.trim().is_empty() {
            continue;
        }
        check_hour(line).map_err(|why| malformed(format!("line {}: {why}", index + 1)))?;
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
    let hour = |line: &str| {
        let mut columns = line.split(',');
        let [_, month, day] = std::array::from_fn(|_| columns.next().unwrap_or_default().trim());
        let is_leap_day = month.parse() == Ok(2) && day.parse() == Ok(29);
        let dry_bulb = columns.nth(DRY_BULB - 3)?.trim().parse().ok();
        dry_bulb.filter(|_| !is_leap_day)
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
    }
    if columns < COLUMNS {
        return Err(format!("{columns} columns instead of {COLUMNS}"));
    }
    Ok(())
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
    }
}
