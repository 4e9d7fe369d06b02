//! Dates, holidays and daylight time in the calendar of an episode.

use std::fmt;

use b2b_base::calendar::Calendar;
use serde::Deserialize;

/// Days of a year without 29 February, which has the prices of the day before.
pub(crate) const DAYS: u32 = 365;
/// Quarter-hours of a day.
pub(crate) const DAY: u32 = 96;
/// A year without 29 February, for dates.
pub(crate) const COMMON: Calendar = Calendar::new(0, false);

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
    /// Day of the year, from 1.
    pub day: u32,
    /// Hour of the day, 0 to 24.
    pub hour: f64,
}

/// A date of every year, such as `12-25`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Date {
    /// Day of a year without 29 February, 1 to 365.
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

/// Returns the quarter-hours of a year.
pub(crate) fn quarters(calendar: Calendar) -> usize {
    (calendar.days() * DAY) as usize
}

/// Returns the local clock's advance over standard time in quarter-hours at a quarter-hour of the year in standard
/// time, by the rule of the United States and Canada: from the second Sunday of March, 2:00, to the first Sunday of
/// November, 2:00 daylight time.
pub(crate) fn advance(calendar: Calendar, quarter: u32) -> u32 {
    let calendar = calendar.year_of(quarter / DAY + 1);
    let start = (nth(calendar, 6, 1, 2) - 1) * DAY + 2 * 4;
    let end = (nth(calendar, 6, 0, 10) - 1) * DAY + 4;
    if (start..end).contains(&quarter) { 4 } else { 0 }
}

/// Returns whether a day of the year is a holiday.
pub(crate) fn is_on(holiday: Holiday, calendar: Calendar, day: u32) -> bool {
    match holiday {
        Holiday::Fixed(date) => calendar.date(day) == COMMON.date(date.day),
        Holiday::Nth { ordinal, weekday, month } => {
            day == nth(calendar.year_of(day), weekday, ordinal, month)
        }
    }
}

/// Returns the day of the year of the nth weekday (from 0; 4 is the last) of a month (from 0) of a whole year.
fn nth(calendar: Calendar, weekday: u32, ordinal: u32, month: usize) -> u32 {
    let first = calendar.month_start(month);
    let days = first..first + calendar.month_days(month);
    let mut matching = days.filter(|day| calendar.weekday(*day) == weekday);
    let found = if ordinal < 4 { matching.nth(ordinal as usize) } else { matching.next_back() };
    found.unwrap_or(first)
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [month, day] = COMMON.date(self.day);
        write!(f, "{month:02}-{day:02}")
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
    COMMON.day([month.parse().ok()?, day.parse().ok()?]).map(|day| Date { day })
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

    fn in_calendar(calendar: Calendar, text: &str) -> u32 {
        let holiday = Holiday::try_from(text.to_owned()).unwrap();
        (1..=calendar.days()).find(|day| is_on(holiday, calendar, *day)).unwrap()
    }

    /// Returns the day in 2017.
    fn named(text: &str) -> u32 {
        in_calendar(Calendar::default(), text)
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
    fn holidays_of_a_leap_year_and_after_new_year_fall_on_their_dates() {
        let of_2020 = Calendar::new(2, true);
        assert_eq!(in_calendar(of_2020, "12-25"), 360);
        assert_eq!(in_calendar(of_2020, "last Monday of May"), of_2020.day([5, 25]).unwrap());
        let winter = Calendar::default().passing_new_year(361);
        assert_eq!(in_calendar(winter, "third Monday of January"), 15, "of 2018");
        // From 2 November 2017 to January 2018: 1 November is a day of 2018.
        let autumn = Calendar::default().passing_new_year(306);
        assert_eq!(in_calendar(autumn, "fourth Thursday of November"), 327, "23 November");
        let [before, after] = [4, 5].map(|day| advance(autumn, (304 + day - 1) * DAY + 48));
        assert_eq!((before, after), (4, 0), "daylight time ends on 5 November");
    }

    #[test]
    fn daylight_time_of_2017_lasts_from_12_march_to_5_november() {
        let at =
            |text, hour: u32| advance(Calendar::default(), (date(text).unwrap().day - 1) * DAY + hour * 4);
        assert_eq!((at("03-12", 1), at("03-12", 2)), (0, 4));
        // 1:00 standard time is 2:00 daylight time.
        assert_eq!((at("11-05", 0), at("11-05", 1)), (4, 0));
        assert_eq!((at("01-15", 12), at("07-15", 12)), (0, 4));
    }

    #[test]
    fn days_have_their_dates() {
        assert_eq!(
            [1, 59, 60, 365].map(|day| Date { day }.to_string()),
            ["01-01", "02-28", "03-01", "12-31"]
        );
        assert!(date("02-29").is_none() && date("13-01").is_none() && date("0-1").is_none());
    }
}
