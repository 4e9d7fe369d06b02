//! Weather with warmer or colder air.

use b2b_base::calendar::Calendar;

use super::record::HEADER_LINES;
use super::row::{COLUMNS, RADIATIONS, Row};
use super::{EpwFile, column};
use crate::Result;

/// Absolute temperature of 0 °C, K.
const FREEZING: f64 = 273.15;
/// Number of the columns of the air that are shifted: dry bulb and dew point.
const SHIFTED: usize = 2;

impl EpwFile {
    /// Returns the text of the file with the air of every hour warmer by `shifts`, K, in the order of a calendar's year.
    ///
    /// Dry bulb and dew point are shifted, relative humidity stays, and the long-wave radiation of the sky follows the
    /// fourth power of the absolute temperature. Values stay plausible. Dates that the calendar does not have, and missing
    /// values, stay as they are.
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
    let infrared = values[column::INFRARED].trim().parse().ok().filter(|value| RADIATIONS.contains(value));
    let mut write = |column: usize, value: f64| values[column] = format!("{value:.3}");
    for (column, value) in COLUMNS.iter().zip(row.air).take(SHIFTED) {
        if let Some(value) = value {
            let [low, high] = column.limits;
            write(column.index, (value + shift).clamp(low, high));
        }
    }
    if let Some((infrared, dry_bulb)) = infrared.zip(row.air[0]) {
        let ratio = 1.0 + shift / (dry_bulb + FREEZING);
        write(column::INFRARED, infrared * (ratio * ratio) * (ratio * ratio));
    }
    values.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mild_year;

    /// Returns a file with the rows of a year, some of them changed, and its text with an hour that is 1.5 K warmer.
    fn warmer_hour(
        calendar: Calendar,
        hour: usize,
        change: impl Fn(usize, &str) -> String,
    ) -> [Vec<String>; 2] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.epw");
        let year = mild_year(calendar.is_leap());
        let rows = year.lines().enumerate().map(|(line, row)| change(line, row) + "\n");
        std::fs::write(&path, rows.collect::<String>()).unwrap();
        let file = EpwFile::open(&path).unwrap();
        let mut shifts = vec![0.0; 24 * calendar.days() as usize];
        shifts[hour] = 1.5;
        let text = file.with_warmer_air(calendar, &shifts).unwrap();
        [file.text(), &text].map(|text| text.lines().map(str::to_owned).collect())
    }

    /// Returns the one row that differs in its values.
    fn changed([before, after]: &[Vec<String>; 2]) -> (&str, &str) {
        let number = |text: &str| text.parse::<f64>().map_err(|_| text.to_owned());
        let values = |row: &str| row.split(',').map(number).collect::<Vec<_>>();
        assert_eq!(before.len(), after.len());
        let differ = before.iter().zip(after).filter(|(before, after)| values(before) != values(after));
        let all: Vec<_> = differ.collect();
        assert_eq!(all.len(), 1, "{all:?}");
        (all[0].0, all[0].1)
    }

    #[test]
    fn the_air_of_one_hour_is_warmer_and_everything_else_stays() {
        let texts = warmer_hour(Calendar::default(), 24 * 59 + 2, |_, row| row.to_owned());
        let (before, after) = changed(&texts);
        assert!(before.starts_with("2017,3,1,3,60,?,20,9,50,101325,0,0,330,0,"), "{before}");
        assert!(after.starts_with("2017,3,1,3,60,?,21.500,10.500,50,101325,0,0,336.806,0,"), "{after}");
        let texts = warmer_hour(Calendar::new(0, true), 24 * 59 + 2, |_, row| row.to_owned());
        assert!(changed(&texts).0.starts_with("2017,2,29,3,"), "in a leap year");
    }

    #[test]
    fn missing_values_stay_missing_and_others_plausible() {
        let extreme = |line: usize, row: &str| match line {
            8 => row.replace(",20,9,50,101325,0,0,330,", ",59,99.9,50,101325,0,0,9999,"),
            _ => row.to_owned(),
        };
        let texts = warmer_hour(Calendar::default(), 0, extreme);
        assert!(changed(&texts).1.starts_with("2017,1,1,1,60,?,60.000,99.9,50,101325,0,0,9999,"));
    }
}
