//! The hours of an EPW file, as the engine reads them: by date, with the codes of missing values replaced.

use std::path::Path;

use b2b_base::calendar::{Calendar, MONTH_DAYS};

use super::row::{COLUMNS, RADIATION, Row};
use crate::{Error, Result};

/// Lines of the header.
pub(super) const HEADER_LINES: usize = 8;
/// Days of a year without 29 February.
const DAYS: usize = 365;
/// Days before 29 February.
const BEFORE_LEAP_DAY: usize = 59;
/// Values of [`COLUMNS`] but the pressure that the engine takes before the first one that is not missing.
const FIRST: [f64; 4] = [6.0, 3.0, 50.0, 2.5];
/// Hours in a row in which a value may be missing.
const LONGEST_GAP: usize = 6;

/// The hours of a weather file.
///
/// A missing temperature, humidity or wind speed takes the last value before it, and missing radiation is 0, as in the
/// engine, for at most six hours in a row. Of a date that the file has in several years, the first one counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Rows per hour.
    intervals: u32,
    /// The earliest and the latest year of the rows.
    years: Option<[u32; 2]>,
    /// In the order of the file, without repeated dates.
    hours: Vec<Hour>,
    /// The first of the 24 hours of every day of a year without 29 February, if the file has it.
    days: Vec<Option<usize>>,
    /// The first of the 24 hours of 29 February, if the file has it.
    leap_day: Option<usize>,
}

/// An hour of weather.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hour {
    /// From 0.
    pub month: usize,
    /// Dry bulb at the end of the hour, °C.
    pub dry_bulb: f64,
    /// Dew point at the end of the hour, °C.
    pub dew_point: f64,
    /// Relative humidity at the end of the hour, %.
    pub relative_humidity: f64,
    /// Wind speed at the end of the hour, m/s.
    pub wind_speed: f64,
    /// Mean global horizontal radiation, W/m².
    pub radiation: f64,
    /// Mean direct normal radiation, W/m².
    pub direct_radiation: f64,
    /// Mean diffuse horizontal radiation, W/m².
    pub diffuse_radiation: f64,
}

impl Record {
    /// Reads the hours of an EPW text; `path` is used in error messages.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line and the reason: a row that the engine cannot read or that is not plausible, a
    /// row that is shorter than the others, a value that is missing for hours, an hour or a day out of sequence, or an
    /// incomplete last day.
    pub(crate) fn of(text: &str, path: &Path) -> Result<Self> {
        Self::read(text).map_err(|why| Error::Malformed { path: path.to_owned(), why })
    }

    /// As [`Record::of`].
    ///
    /// # Errors
    /// The line and the reason.
    pub(super) fn read(text: &str) -> std::result::Result<Self, String> {
        let hint = if text.starts_with("LOCATION") { "" } else { "; an EPW file begins with LOCATION" };
        let (intervals, periods) = data_periods(text)?;
        let mut reader = Reader::new(intervals, periods > 1);
        for (index, line) in text.lines().enumerate().skip(HEADER_LINES) {
            if !line.trim().is_empty() {
                let read = Row::read(line).and_then(|row| reader.add(&row));
                read.map_err(|why| format!("line {}: {why}{hint}", index + 1))?;
            }
        }
        reader.finish()
    }

    /// Returns the number of rows per hour.
    pub fn intervals(&self) -> u32 {
        self.intervals
    }

    /// Returns the year of the rows, if they have one in common, as in a measured year.
    pub fn year(&self) -> Option<u32> {
        self.years.filter(|[first, last]| first == last).map(|[year, _]| year)
    }

    /// Returns whether 29 February is in the file.
    pub fn has_leap_day(&self) -> bool {
        self.leap_day.is_some()
    }

    /// Returns whether every day of a year without 29 February is in the file.
    pub fn is_whole_year(&self) -> bool {
        self.days.iter().all(Option::is_some)
    }

    /// Returns whether a date, its month and day of the month, is in the file.
    pub fn has(&self, date: [u32; 2]) -> bool {
        match day_of_year(date) {
            Some(day) => self.days[day].is_some(),
            None => self.has_leap_day(),
        }
    }

    /// Returns the days of the year, from 1 and without 29 February, on which the file begins and ends.
    pub fn span(&self) -> Option<[u32; 2]> {
        let with_start = self.days.iter().zip(1..).filter_map(|(start, day)| Some(((*start)?, day)));
        let of = |best: Option<(usize, u32)>| best.map(|(_, day)| day);
        Some([of(with_start.clone().min())?, of(with_start.max())?])
    }

    /// Returns the dry bulb at the end of each hour of a year without 29 February, °C. A missing day has the values of
    /// the nearest.
    pub fn dry_bulbs(&self) -> Vec<f64> {
        self.dry_bulbs_in(Calendar::default())
    }

    /// Returns the dry bulb at the end of each hour of the year of a calendar, like [`Record::dry_bulbs`].
    pub fn dry_bulbs_in(&self, calendar: Calendar) -> Vec<f64> {
        self.by_date(calendar, |hour| hour.dry_bulb)
    }

    /// Returns the mean global horizontal radiation of each hour of the year of a calendar, W/m². A missing day has the
    /// values of the nearest.
    pub fn global_radiation_in(&self, calendar: Calendar) -> Vec<f64> {
        self.by_date(calendar, |hour| hour.radiation)
    }

    /// Returns the hours in the order of the file.
    pub(crate) fn hours(&self) -> &[Hour] {
        &self.hours
    }

    /// Returns the mean dry bulb of each month, °C; `None` if a month has no hours.
    pub(crate) fn monthly_dry_bulbs(&self) -> Option<[f64; 12]> {
        let (mut sums, mut counts) = ([0.0; 12], [0.0; 12]);
        for hour in &self.hours {
            sums[hour.month] += hour.dry_bulb;
            counts[hour.month] += 1.0;
        }
        let means = std::array::from_fn(|month| sums[month] / counts[month]);
        means.iter().all(|mean: &f64| mean.is_finite()).then_some(means)
    }

    /// Returns the mean dry bulb, °C; NaN without hours.
    pub(crate) fn mean_dry_bulb(&self) -> f64 {
        mean(self.hours.iter().map(|hour| hour.dry_bulb))
    }

    /// Returns a value of each hour of the year of a calendar. A missing day has the values of the nearest.
    pub fn by_date(&self, calendar: Calendar, value: impl Fn(&Hour) -> f64) -> Vec<f64> {
        let nearest = |days: std::ops::Range<usize>| days.filter_map(|day| self.nearest(day));
        let leap_day = self.leap_day.or_else(|| self.nearest(BEFORE_LEAP_DAY)).filter(|_| calendar.is_leap());
        let starts = nearest(0..BEFORE_LEAP_DAY).chain(leap_day).chain(nearest(BEFORE_LEAP_DAY..DAYS));
        starts.flat_map(|start| &self.hours[start..start + 24]).map(value).collect()
    }

    /// Returns the first hour of the nearest day of the file.
    fn nearest(&self, day: usize) -> Option<usize> {
        (0..DAYS).find_map(|away| self.days[(day + DAYS - away) % DAYS].or(self.days[(day + away) % DAYS]))
    }
}

/// Returns the mean of values; NaN for none.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Returns the rows per hour and the number of periods in the header; 1 and 1 without the line.
fn data_periods(text: &str) -> std::result::Result<(u32, u32), String> {
    let line = text.lines().take(HEADER_LINES).find(|line| {
        line.split(',').next().is_some_and(|title| title.trim().eq_ignore_ascii_case("DATA PERIODS"))
    });
    let Some(line) = line else { return Ok((1, 1)) };
    let mut fields = line.split(',').skip(1).map(|field| field.trim().parse().ok());
    let mut next = || fields.next().flatten();
    let (periods, intervals) = (next(), next());
    match intervals {
        Some(intervals @ (1 | 2 | 3 | 4 | 5 | 6 | 10 | 12 | 15 | 20 | 30 | 60)) => {
            Ok((intervals, periods.unwrap_or(1)))
        }
        _ => Err(format!(
            "`{line}` does not give the rows per hour; expected DATA PERIODS,1, and a number that divides 60"
        )),
    }
}

/// Reads rows one after the other.
struct Reader {
    record: Record,
    /// Whether gaps between days are allowed.
    has_gaps: bool,
    rows: usize,
    columns: usize,
    date: [u32; 2],
    /// Whether the date of the current day has been read before.
    repeated: bool,
    /// Last dry bulb, dew point, humidity and wind speed.
    last: [f64; 4],
    /// Global, direct and diffuse radiation of the rows of the current hour.
    radiation: [f64; 3],
    gaps: Gaps,
}

impl Reader {
    fn new(intervals: u32, has_gaps: bool) -> Self {
        Self {
            record: Record {
                intervals,
                years: None,
                hours: Vec::new(),
                days: vec![None; DAYS],
                leap_day: None,
            },
            has_gaps,
            rows: 0,
            columns: 0,
            date: [0, 0],
            repeated: false,
            last: FIRST,
            radiation: [0.0; 3],
            gaps: Gaps::default(),
        }
    }

    fn add(&mut self, row: &Row) -> std::result::Result<(), String> {
        let intervals = self.record.intervals as usize;
        let (in_hour, hour) = (self.rows % intervals, self.rows / intervals % 24 + 1);
        if self.rows == 0 {
            self.columns = row.columns;
        } else if row.columns < self.columns {
            return Err(format!(
                "{} columns instead of {} as before: it is truncated",
                row.columns, self.columns
            ));
        }
        if row.hour as usize != hour {
            return Err(format!(
                "hour {}; expected hour {hour} of a day from 1 to 24 with {intervals} row(s) each",
                row.hour
            ));
        }
        match hour == 1 && in_hour == 0 {
            true => self.begin_day([row.month, row.day])?,
            false if [row.month, row.day] != self.date => {
                let [month, day] = self.date;
                return Err(format!(
                    "date {:02}-{:02} in the middle of the day {month:02}-{day:02}",
                    row.month, row.day
                ));
            }
            false => {}
        }
        self.rows += 1;
        let [earliest, latest] = self.record.years.unwrap_or([row.year; 2]);
        self.record.years = Some([earliest.min(row.year), latest.max(row.year)]);
        self.gaps.add(row, LONGEST_GAP * intervals)?;
        for (last, value) in self.last.iter_mut().zip(row.air) {
            *last = value.unwrap_or(*last);
        }
        for (sum, value) in self.radiation.iter_mut().zip(row.radiation) {
            *sum += value.unwrap_or(0.0);
        }
        if in_hour + 1 == intervals {
            self.end_hour();
        }
        Ok(())
    }

    fn begin_day(&mut self, date: [u32; 2]) -> std::result::Result<(), String> {
        let [month, day] = date;
        if !exists(date) {
            return Err(format!("month {month} and day {day} are not a date"));
        }
        if self.rows > 0 && !self.has_gaps && !follows(self.date, date) {
            let [before, yesterday] = self.date;
            return Err(format!(
                "{month:02}-{day:02} follows {before:02}-{yesterday:02}: days are missing or out of order, and the engine \
                 would use the wrong days"
            ));
        }
        self.date = date;
        let start = match day_of_year(date) {
            Some(day) => &mut self.record.days[day],
            None => &mut self.record.leap_day,
        };
        self.repeated = start.is_some();
        start.get_or_insert(self.record.hours.len());
        Ok(())
    }

    fn end_hour(&mut self) {
        let intervals = f64::from(self.record.intervals);
        let [radiation, direct_radiation, diffuse_radiation] =
            std::mem::take(&mut self.radiation).map(|sum| sum / intervals);
        if !self.repeated {
            let [dry_bulb, dew_point, relative_humidity, wind_speed] = self.last;
            self.record.hours.push(Hour {
                month: self.date[0] as usize - 1,
                dry_bulb,
                dew_point,
                relative_humidity,
                wind_speed,
                radiation,
                direct_radiation,
                diffuse_radiation,
            });
        }
    }

    fn finish(self) -> std::result::Result<Record, String> {
        let per_day = 24 * self.record.intervals as usize;
        if self.rows.is_multiple_of(per_day) {
            return Ok(self.record);
        }
        let [month, day] = self.date;
        let there = self.rows % per_day;
        Err(format!(
            "the last day, {month:02}-{day:02}, has {there} of {per_day} rows: the file is truncated after {} rows",
            self.rows
        ))
    }
}

/// Numbers of rows since a value was there.
#[derive(Default)]
struct Gaps {
    air: [usize; FIRST.len()],
    /// Since the last one above 0: what is missing at night ends no gap of days.
    radiation: [usize; RADIATION.len()],
}

impl Gaps {
    fn add(&mut self, row: &Row, longest: usize) -> std::result::Result<(), String> {
        let air = self.air.iter_mut().zip(COLUMNS.map(|column| column.quantity)).zip(row.air);
        let radiation = self.radiation.iter_mut().zip(RADIATION.map(|(_, quantity)| quantity));
        let air = air.map(|(gap, value)| (gap, value.is_none(), value.is_some()));
        let radiation = radiation.zip(row.radiation);
        let radiation = radiation.map(|(gap, value)| (gap, value.is_none(), value > Some(0.0)));
        for ((gap, quantity), is_missing, ends) in air.chain(radiation) {
            *gap = if ends { 0 } else { *gap + usize::from(is_missing) };
            if *gap > longest {
                return Err(format!(
                    "the {quantity} is missing for more than {LONGEST_GAP} hours, and the engine would invent it; fill \
                     the gap"
                ));
            }
        }
        Ok(())
    }
}

fn exists([month, day]: [u32; 2]) -> bool {
    let days = MONTH_DAYS.get((month as usize).wrapping_sub(1));
    day >= 1 && days.is_some_and(|days| day <= *days || (month, day) == (2, 29))
}

/// Returns the day of the year from 0; `None` for 29 February.
fn day_of_year([month, day]: [u32; 2]) -> Option<usize> {
    let before = MONTH_DAYS[..month as usize - 1].iter().sum::<u32>();
    ((month, day) != (2, 29)).then(|| (before + day) as usize - 1)
}

/// Returns whether a date is the day after another, in a leap year or not.
fn follows(before: [u32; 2], date: [u32; 2]) -> bool {
    match (day_of_year(before), day_of_year(date)) {
        (Some(before), Some(date)) => (before + 1) % DAYS == date,
        (Some(_), None) => before == [2, 28],
        (None, _) => date == [3, 1],
    }
}

#[cfg(test)]
mod tests;
