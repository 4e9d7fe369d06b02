//! The calendar of an episode: a common year of 365 days, its weekdays, holidays and daylight time.

use std::fmt;

use serde::Deserialize;

/// Days of the year.
pub const DAYS: u32 = 365;
/// Quarter-hours of a day.
pub(crate) const DAY: u32 = 96;
/// Quarter-hours of the year.
pub(crate) const QUARTERS: usize = (DAYS * DAY) as usize;
/// Days of the months.
pub(crate) const MONTH_DAYS: [u32; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

const MONTHS: [&str; 12] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];
const WEEKDAYS: [&str; 7] = ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"];
const ORDINALS: [&str; 5] = ["first", "second", "third", "fourth", "last"];

/// A time of the year, on the clock of the simulation (standard time).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Day of the year, 1 to 365.
    pub day: u32,
    /// Hour of the day, 0 to 24.
    pub hour: f64,
}

/// A calendar year: 365 days that begin on a given day of the week.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Year {
    first_weekday: u32,
}

/// A day of the year by its date, such as `12-25`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Date {
    /// Day of the year, 1 to 365.
    pub(crate) day: u32,
}

/// A holiday: a date, or a rule such as `last Monday of May`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) enum Holiday {
    /// The same date every year.
    Fixed(Date),
    /// The nth weekday of a month.
    Nth {
        /// 0 (first) to 3 (fourth), 4 is the last.
        ordinal: u32,
        /// 0 (Monday) to 6 (Sunday).
        weekday: u32,
        /// 0 to 11.
        month: usize,
    },
}

impl Moment {
    /// Returns the quarter-hours since the start of the year.
    pub(crate) fn quarters(self) -> f64 {
        (f64::from(self.day - 1) * 24.0 + self.hour) * 4.0
    }
}

impl Year {
    /// Returns the year that begins on a day of the week, 0 (Monday) to 6 (Sunday).
    pub const fn starting_on(first_weekday: u32) -> Self {
        Self { first_weekday: first_weekday % 7 }
    }

    /// Returns the day of the week, 0 (Monday) to 6 (Sunday), of a day of the year, 1 to 365.
    pub const fn weekday(self, day: u32) -> u32 {
        (self.first_weekday + day - 1) % 7
    }

    /// Returns the local clock's advance over standard time in quarter-hours at a quarter-hour of the year in standard time,
    /// by the rule of the United States and Canada: from the second Sunday of March, 2:00, to the first Sunday of November,
    /// 2:00 daylight time.
    pub(crate) fn advance(self, quarter: u32) -> u32 {
        let start = (self.nth(6, 1, 2) - 1) * DAY + 2 * 4;
        let end = (self.nth(6, 0, 10) - 1) * DAY + 4;
        if (start..end).contains(&quarter) { 4 } else { 0 }
    }

    /// Returns the day of the year of a holiday.
    pub(crate) fn day_of(self, holiday: Holiday) -> u32 {
        match holiday {
            Holiday::Fixed(date) => date.day,
            Holiday::Nth { ordinal, weekday, month } => self.nth(weekday, ordinal, month),
        }
    }

    /// Returns the day of the year of the nth weekday (from 0; 4 is the last) of a month (from 0).
    fn nth(self, weekday: u32, ordinal: u32, month: usize) -> u32 {
        let first = month_start(month);
        let days = first..first + MONTH_DAYS[month];
        let mut matching = days.filter(|day| self.weekday(*day) == weekday);
        let found = if ordinal < 4 { matching.nth(ordinal as usize) } else { matching.next_back() };
        found.expect("every month has four of each weekday")
    }
}

/// Returns the first day of the year of a month from 0.
pub(crate) fn month_start(month: usize) -> u32 {
    MONTH_DAYS[..month].iter().sum::<u32>() + 1
}

/// Returns the month from 0 of a day of the year, 1 to 365.
pub(crate) fn month_of(day: u32) -> usize {
    (1..12).take_while(|month| month_start(*month) <= day).count()
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let month = month_of(self.day);
        write!(f, "{:02}-{:02}", month + 1, self.day - month_start(month) + 1)
    }
}

impl TryFrom<String> for Date {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        date(&text).ok_or_else(|| format!("`{text}` is not a date; expected MM-DD, such as 12-25"))
    }
}

/// Returns the date of a text `MM-DD`.
pub(crate) fn date(text: &str) -> Option<Date> {
    let (month, day) = text.trim().split_once('-')?;
    let (month, day): (usize, u32) = (month.parse().ok()?, day.parse().ok()?);
    let month = month.checked_sub(1).filter(|month| *month < 12)?;
    (1..=MONTH_DAYS[month]).contains(&day).then(|| Date { day: month_start(month) + day - 1 })
}

impl TryFrom<String> for Holiday {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let found = date(&text).map(Self::Fixed).or_else(|| nth_weekday(&text));
        found.ok_or_else(|| {
            format!("`{text}` is not a holiday; expected MM-DD or a rule such as `last Monday of May`")
        })
    }
}

fn nth_weekday(text: &str) -> Option<Holiday> {
    let mut words = text.split_whitespace();
    let mut among = |names: &[&str]| {
        let word = words.next()?;
        names.iter().position(|name| name.eq_ignore_ascii_case(word))
    };
    let (ordinal, weekday) = (among(&ORDINALS)?, among(&WEEKDAYS)?);
    let (_, month) = (among(&["of"])?, among(&MONTHS)?);
    words.next().is_none().then_some(Holiday::Nth { ordinal: ordinal as u32, weekday: weekday as u32, month })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2017, the year of the episodes.
    const YEAR: Year = Year::starting_on(6);

    fn named(text: &str) -> u32 {
        YEAR.day_of(Holiday::try_from(text.to_owned()).unwrap())
    }

    #[test]
    fn holidays_of_2017_fall_on_their_dates() {
        let day = |text| date(text).unwrap().day;
        assert_eq!(named("last Monday of May"), day("05-29"));
        assert_eq!(named("first Monday of September"), day("09-04"));
        assert_eq!(named("fourth Thursday of November"), day("11-23"));
        assert_eq!(named("12-25"), day("12-25"));
        assert_eq!(named("12-25"), 359);
    }

    #[test]
    fn daylight_time_of_2017_lasts_from_12_march_to_5_november() {
        let at = |text, hour: u32| YEAR.advance((date(text).unwrap().day - 1) * DAY + hour * 4);
        assert_eq!((at("03-12", 1), at("03-12", 2)), (0, 4));
        // 1:00 standard time is 2:00 daylight time.
        assert_eq!((at("11-05", 0), at("11-05", 1)), (4, 0));
        assert_eq!((at("01-15", 12), at("07-15", 12)), (0, 4));
    }

    #[test]
    fn days_have_their_months_and_dates() {
        assert_eq!([1, 31, 32, 59, 60, 365].map(month_of), [0, 0, 1, 1, 2, 11]);
        assert_eq!(
            [1, 59, 60, 365].map(|day| Date { day }.to_string()),
            ["01-01", "02-28", "03-01", "12-31"]
        );
        assert!(date("02-29").is_none() && date("13-01").is_none() && date("0-1").is_none());
    }
}
