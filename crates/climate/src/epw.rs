//! Whether an EPW weather file is whole.
//!
//! EnergyPlus stops in the middle of a run on a truncated file, far from the cause; here the cause is named
//! before the engine sees it.

use std::path::Path;

use crate::{Error, Result};

/// Header lines before the first hour.
const HEADER_LINES: usize = 8;
/// Columns of an hour that EnergyPlus reads.
const COLUMNS: usize = 35;
/// The column of source and uncertainty flags, the only one that is text.
const FLAGS: usize = 5;
/// Hours of a common and of a leap year.
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
            "{hours} hours of weather instead of 8760 (or 8784): the file is cut short or not a whole year"
        )))
    }
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
    fn a_common_and_a_leap_year_are_whole() {
        for hours in HOURS {
            assert_eq!(check(&year(hours), Path::new("a.epw")).unwrap(), hours);
        }
    }

    #[test]
    fn a_truncated_file_is_named_with_its_hours() {
        let why = why(&year(5000));
        assert!(why.contains("a.epw") && why.contains("5000"), "{why}");
    }

    #[test]
    fn a_cut_line_and_a_nan_are_named_with_their_line() {
        let mut text = year(8760);
        text.truncate(text.len() - 20);
        assert!(why(&text).contains("line 8768"), "{}", why(&text));
        let text = year(8760).replacen("1.5", "nan", 1);
        assert!(why(&text).contains("line 9: column 7"), "{}", why(&text));
    }
}
