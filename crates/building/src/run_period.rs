//! Run periods: the days of an episode.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::{Error, Result};

/// The calendar year of every episode: a common year, as in weather files, that starts on a Sunday.
const YEAR: u32 = 2017;
const MONTH_DAYS: [u32; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
pub(crate) const WEEKDAYS: [&str; 7] =
    ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"];

/// A day of the year.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Date {
    month: u32,
    day: u32,
}

/// The first and the last day of an episode, both inclusive, within one year.
///
/// Serialized as text, for example `01-01..03-31`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct RunPeriod {
    first: Date,
    last: Date,
}

impl Date {
    /// The date of a month and a day, both from 1.
    ///
    /// # Errors
    /// [`Error::Date`] when the date does not exist.
    pub fn new(month: u32, day: u32) -> Result<Self> {
        let days = (1..=12).contains(&month).then(|| MONTH_DAYS[month as usize - 1]);
        match days {
            Some(days) if (1..=days).contains(&day) => Ok(Self { month, day }),
            _ => Err(Error::Date { text: format!("{month:02}-{day:02}") }),
        }
    }

    /// The date of a day of the year, 1 to 365.
    pub fn of_day(mut day_of_year: u32) -> Self {
        for (month, days) in (1..).zip(MONTH_DAYS) {
            if day_of_year <= days {
                return Self { month, day: day_of_year.max(1) };
            }
            day_of_year -= days;
        }
        Self { month: 12, day: 31 }
    }

    /// Month, 1 to 12.
    pub fn month(self) -> u32 {
        self.month
    }

    /// Day of the month, from 1.
    pub fn day(self) -> u32 {
        self.day
    }

    /// Day of the year, 1 to 365.
    pub fn day_of_year(self) -> u32 {
        MONTH_DAYS[..self.month as usize - 1].iter().sum::<u32>() + self.day
    }

    /// Returns the day of the week of 1 January of the year in which this date is on a given day of the week, 0 (Monday) to 6
    /// (Sunday).
    pub(crate) fn new_year_if_on(self, weekday: u32) -> u32 {
        (weekday + 371 - (self.day_of_year() - 1)) % 7
    }

    /// Day of the week, 0 (Monday) to 6 (Sunday).
    pub fn weekday(self) -> u32 {
        // 1 January of the calendar year is a Sunday.
        (self.day_of_year() - 1 + 6) % 7
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02}-{:02}", self.month, self.day)
    }
}

impl FromStr for Date {
    type Err = Error;

    /// Parses `MM-DD`.
    fn from_str(text: &str) -> Result<Self> {
        let date = text
            .split_once('-')
            .and_then(|(month, day)| Self::new(month.trim().parse().ok()?, day.trim().parse().ok()?).ok());
        date.ok_or_else(|| Error::Date { text: text.to_owned() })
    }
}

impl TryFrom<String> for RunPeriod {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<RunPeriod> for String {
    fn from(period: RunPeriod) -> Self {
        period.to_string()
    }
}

impl RunPeriod {
    /// 1 January to 31 December.
    pub const FULL_YEAR: Self = Self::between((1, 1), (12, 31));
    /// 1 January to 31 March: 90 days.
    pub const WINTER: Self = Self::between((1, 1), (3, 31));
    /// 1 June to 31 August: 92 days.
    pub const SUMMER: Self = Self::between((6, 1), (8, 31));

    const fn between(first: (u32, u32), last: (u32, u32)) -> Self {
        Self { first: Date { month: first.0, day: first.1 }, last: Date { month: last.0, day: last.1 } }
    }

    /// A run period from a first to a last day, both inclusive.
    ///
    /// # Errors
    /// [`Error::RunPeriod`] when it ends before it starts: an episode stays within one year.
    pub fn new(first: Date, last: Date) -> Result<Self> {
        if last < first {
            return Err(Error::RunPeriod { text: format!("{first}..{last}") });
        }
        Ok(Self { first, last })
    }

    /// Returns the part of `days` days that begins `after` days after the first, cut at the end of the period.
    pub fn part(self, after: u32, days: u32) -> Self {
        let whole = self.days();
        let after = after.min(whole - 1);
        let first = self.first.day_of_year() + after;
        let last = first + days.clamp(1, whole - after) - 1;
        Self { first: Date::of_day(first), last: Date::of_day(last) }
    }

    /// First day.
    pub fn first(self) -> Date {
        self.first
    }

    /// Last day.
    pub fn last(self) -> Date {
        self.last
    }

    /// Number of days.
    pub fn days(self) -> u32 {
        self.last.day_of_year() - self.first.day_of_year() + 1
    }

    /// The fields of the engine's `RunPeriod` object, with the weekday of the first day: the engine does not derive it from
    /// the year.
    pub(crate) fn to_epjson(self) -> Value {
        json!({
            "begin_month": self.first.month,
            "begin_day_of_month": self.first.day,
            "begin_year": YEAR,
            "end_month": self.last.month,
            "end_day_of_month": self.last.day,
            "end_year": YEAR,
            "day_of_week_for_start_day": WEEKDAYS[self.first.weekday() as usize],
            "use_weather_file_holidays_and_special_days": "No",
            "use_weather_file_daylight_saving_period": "No",
            "apply_weekend_holiday_rule": "No",
            "use_weather_file_rain_indicators": "Yes",
            "use_weather_file_snow_indicators": "Yes",
        })
    }
}

impl fmt::Display for RunPeriod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::FULL_YEAR => f.write_str("full_year"),
            Self::WINTER => f.write_str("winter"),
            Self::SUMMER => f.write_str("summer"),
            Self { first, last } => write!(f, "{first}..{last}"),
        }
    }
}

impl FromStr for RunPeriod {
    type Err = Error;

    /// Parses `winter`, `summer`, `full_year` or `MM-DD..MM-DD`.
    fn from_str(text: &str) -> Result<Self> {
        match text {
            "winter" => Ok(Self::WINTER),
            "summer" => Ok(Self::SUMMER),
            "full_year" => Ok(Self::FULL_YEAR),
            _ => {
                let (first, last) =
                    text.split_once("..").ok_or_else(|| Error::RunPeriod { text: text.to_owned() })?;
                Self::new(first.parse()?, last.parse()?)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn winter_has_90_days_and_summer_92() {
        assert_eq!(RunPeriod::WINTER.days(), 90);
        assert_eq!(RunPeriod::SUMMER.days(), 92);
        assert_eq!(RunPeriod::FULL_YEAR.days(), 365);
    }

    #[test]
    fn the_weekday_follows_the_date() {
        assert_eq!(Date::new(1, 1).unwrap().weekday(), 6, "1 January 2017 was a Sunday");
        assert_eq!(Date::new(6, 1).unwrap().weekday(), 3, "1 June 2017 was a Thursday");
    }

    #[test]
    fn every_day_of_the_year_has_one_date() {
        for day in 1..=365 {
            assert_eq!(Date::of_day(day).day_of_year(), day);
        }
    }

    #[test]
    fn a_run_period_round_trips_through_text() {
        for text in ["winter", "summer", "full_year", "02-03..02-10"] {
            assert_eq!(text.parse::<RunPeriod>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn the_error_of_an_invalid_date_has_the_format() {
        for text in ["spring", "02-30..03-01", "03-01..02-01", "0201..0301"] {
            let error = text.parse::<RunPeriod>().unwrap_err().to_string();
            assert!(error.contains("MM-DD"), "{error}");
        }
    }

    #[test]
    fn a_misspelled_run_period_gets_the_nearest() {
        let said = |text: &str| text.parse::<RunPeriod>().unwrap_err().to_string();
        for (text, near) in [("winterr", "winter"), ("Summer", "summer"), ("fullyear", "full_year")] {
            assert!(said(text).contains(&format!("did you mean {near}?")), "{}", said(text));
        }
        assert!(!said("spring").contains("did you mean"), "{}", said("spring"));
    }
}
