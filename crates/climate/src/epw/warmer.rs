//! Weather with warmer or colder air.

use b2b_base::calendar::Calendar;

use super::record::HEADER_LINES;
use super::row::Row;
use super::{EpwFile, column};
use crate::Result;

/// Absolute temperature of 0 °C, K.
const FREEZING: f64 = 273.15;
/// Long-wave radiation from which on a value is missing, W/m².
const MISSING_INFRARED: f64 = 9999.0;

impl EpwFile {
    /// Returns the text of the file with the air of every hour warmer by `shifts`, K, in the order of a calendar's year.
    ///
    /// Dry bulb and dew point are shifted, relative humidity stays, and the long-wave radiation of the sky follows the
    /// fourth power of the absolute temperature. Dates that the calendar does not have, and missing values, stay as
    /// they are.
    ///
    /// # Errors
    /// The errors of [`EpwFile::record`].
    pub fn with_warmer_air(&self, calendar: Calendar, shifts: &[f64]) -> Result<String> {
        self.record()?;
        let mut text = String::with_capacity(self.text().len());
        for (index, line) in self.text().lines().enumerate() {
            let row = (index >= HEADER_LINES).then(|| Row::read(line).ok()).flatten();
            let shift = row.as_ref().and_then(|row| shifts.get(hour_of_year(row, calendar)?));
            match row.as_ref().zip(shift) {
                Some((row, shift)) => text.push_str(&warmer(line, row, *shift)),
                None => text.push_str(line),
            }
            text.push('\n');
        }
        Ok(text)
    }
}

/// Returns the hour of a calendar's year, from 0, in which a row falls.
fn hour_of_year(row: &Row, calendar: Calendar) -> Option<usize> {
    let day = calendar.day([row.month, row.day])?;
    Some((24 * (day - 1) + row.hour - 1) as usize)
}

/// Returns a row with warmer air.
fn warmer(line: &str, row: &Row, shift: f64) -> String {
    let mut values: Vec<String> = line.split(',').map(str::to_owned).collect();
    let mut write = |column: usize, value: f64| values[column] = format!("{value:.3}");
    let [dry_bulb, dew_point, ..] = row.air;
    for (column, value) in [(column::DRY_BULB, dry_bulb), (column::DEW_POINT, dew_point)] {
        if let Some(value) = value {
            write(column, value + shift);
        }
    }
    let infrared = line.split(',').nth(column::INFRARED).and_then(|text| text.trim().parse::<f64>().ok());
    if let Some((infrared, dry_bulb)) = infrared.filter(|value| *value < MISSING_INFRARED).zip(dry_bulb) {
        let ratio = 1.0 + shift / (dry_bulb + FREEZING);
        write(column::INFRARED, infrared * (ratio * ratio) * (ratio * ratio));
    }
    values.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mild_year;

    #[test]
    fn the_air_of_an_hour_is_warmer_and_everything_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.epw");
        std::fs::write(&path, mild_year(true)).unwrap();
        let file = EpwFile::open(&path).unwrap();
        let mut shifts = vec![0.0; 8760];
        // 1 March, 2:00 to 3:00.
        shifts[24 * 59 + 2] = 1.5;
        let text = file.with_warmer_air(Calendar::default(), &shifts).unwrap();
        let row = |text: &str, line: usize| text.lines().nth(line).unwrap().to_owned();
        // After the header, two months and 29 February.
        let line = 8 + 24 * 60 + 2;
        assert!(row(file.text(), line).starts_with("2017,3,1,3,60,?,20,9,50,101325,0,0,330,0"));
        assert!(row(&text, line).starts_with("2017,3,1,3,60,?,21.500,10.500,50,101325,0,0,336.806,0"));
        std::fs::write(&path, &text).unwrap();
        let warmer = EpwFile::open(&path).unwrap();
        let air = |file: &EpwFile| file.record().unwrap().dry_bulbs_in(Calendar::new(0, true));
        let changed =
            air(&file).iter().zip(air(&warmer)).filter(|(before, after)| **before != *after).count();
        assert_eq!(changed, 1);
    }
}
