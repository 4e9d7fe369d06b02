//! Run periods: the days of an episode.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use b2b_base::calendar::{Calendar, is_leap_year};
use b2b_climate::EpwFile;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::model::text;
use crate::{Error, Model, Result};

/// The first year tried for the days of an episode; 2017 has the days of the week of every generated building.
const FIRST_YEAR: u32 = 2017;
pub(crate) const WEEKDAYS: [&str; 7] =
    ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"];

/// Fields of a model's run period that hold whatever its days are. The engine ends a run of other years than the
/// weather's with `treat_weather_as_actual`, so this is not among them.
const KEPT: [&str; 3] =
    ["apply_weekend_holiday_rule", "use_weather_file_rain_indicators", "use_weather_file_snow_indicators"];

/// A date of every year, or 29 February.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Date {
    month: u32,
    day: u32,
}

/// The first and the last day of an episode, both inclusive. It passes New Year if the last date is before the first.
///
/// It is in the calendar of generated buildings until it is given a building's own
/// ([`PreparedBuilding::in_its_calendar`](crate::PreparedBuilding::in_its_calendar)). Serialized as text, for example
/// `01-01..03-31`, without the calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct RunPeriod {
    first: Date,
    last: Date,
    calendar: Calendar,
}

impl Date {
    /// The date of a month and a day, both from 1.
    ///
    /// # Errors
    /// [`Error::Date`] when the date does not exist.
    pub fn new(month: u32, day: u32) -> Result<Self> {
        let leap_year = Calendar::new(0, true);
        let known = leap_year.day([month, day]).is_some();
        known
            .then_some(Self { month, day })
            .ok_or_else(|| Error::Date { text: format!("{month:02}-{day:02}") })
    }

    /// The date of a day of a year without 29 February, 1 to 365.
    pub fn of_day(day_of_year: u32) -> Self {
        Self::of(Calendar::default(), day_of_year.clamp(1, 365))
    }

    fn of(calendar: Calendar, day_of_year: u32) -> Self {
        let [month, day] = calendar.date(day_of_year);
        Self { month, day }
    }

    /// Month, 1 to 12.
    pub fn month(self) -> u32 {
        self.month
    }

    /// Day of the month, from 1.
    pub fn day(self) -> u32 {
        self.day
    }

    /// Month and day of the month, from 1.
    pub fn month_and_day(self) -> [u32; 2] {
        [self.month, self.day]
    }

    /// Day of a year without 29 February, 1 to 365.
    pub fn day_of_year(self) -> u32 {
        self.in_calendar(Calendar::default())
    }

    /// Day of the year in a calendar. 29 February counts as 28 February in a calendar without it.
    pub(crate) fn in_calendar(self, calendar: Calendar) -> u32 {
        let date = self.month_and_day();
        calendar.day(date).or_else(|| calendar.day([self.month, self.day - 1])).unwrap_or(1)
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

    const NAMED: [(&str, Self); 3] =
        [("winter", Self::WINTER), ("summer", Self::SUMMER), ("full_year", Self::FULL_YEAR)];

    /// Returns the days of a weather file of part of a year, from the first to the last; `None` for one of a whole year.
    ///
    /// # Errors
    /// [`Error::Climate`] when the file cannot be read or has no hours.
    pub fn of_part(weather: &Path) -> Result<Option<Self>> {
        let file = EpwFile::open(weather)?;
        file.check()?;
        let record = file.record()?;
        let span = record.span().filter(|_| !record.is_whole_year());
        Ok(span.map(|days| days.map(Date::of_day)).map(|[first, last]| Self::new(first, last)))
    }

    const fn between(first: (u32, u32), last: (u32, u32)) -> Self {
        Self {
            first: Date { month: first.0, day: first.1 },
            last: Date { month: last.0, day: last.1 },
            calendar: Calendar::new(6, false),
        }
    }

    /// A run period from a first to a last day, both inclusive, which passes New Year if the last is before the first.
    pub fn new(first: Date, last: Date) -> Self {
        Self { first, last, calendar: Calendar::default() }.in_calendar(Calendar::default())
    }

    /// Returns the same dates in the year of a calendar and, if they pass New Year, in the following one.
    #[must_use]
    pub fn in_calendar(self, calendar: Calendar) -> Self {
        let first = self.first.in_calendar(calendar);
        let calendar = if self.passes_new_year() { calendar.passing_new_year(first) } else { calendar };
        Self { calendar, ..self }
    }

    /// Returns the part of `days` days that begins `after` days after the first, cut at the end of the period.
    pub fn part(self, after: u32, days: u32) -> Self {
        let whole = self.days();
        let after = after.min(whole - 1);
        let last = after + days.clamp(1, whole - after) - 1;
        let part = Self { first: self.date(after), last: self.date(last), ..self };
        part.in_calendar(self.calendar.first_year())
    }

    /// First day.
    pub fn first(self) -> Date {
        self.first
    }

    /// Last day.
    pub fn last(self) -> Date {
        self.last
    }

    /// Returns the calendar.
    pub fn calendar(self) -> Calendar {
        self.calendar
    }

    /// Returns whether it passes New Year.
    pub fn passes_new_year(self) -> bool {
        self.last < self.first
    }

    /// Returns the day of the year that is a number of days after the first.
    pub fn day_of_year(self, after: u32) -> u32 {
        self.calendar.after(self.first.in_calendar(self.calendar), after)
    }

    /// Returns the date that is a number of days after the first.
    pub fn date(self, after: u32) -> Date {
        Date::of(self.calendar, self.day_of_year(after))
    }

    /// Returns the day of the year of the last day.
    pub fn last_day_of_year(self) -> u32 {
        self.last.in_calendar(self.calendar)
    }

    /// Number of days.
    pub fn days(self) -> u32 {
        let [first, last] = [self.first, self.last].map(|date| date.in_calendar(self.calendar));
        self.calendar.count(last) - first + 1
    }

    /// Returns whether a day is in both periods.
    pub fn overlaps(self, other: Self) -> bool {
        let is_within = |date: Date, period: Self| match period.passes_new_year() {
            true => date >= period.first || date <= period.last,
            false => (period.first..=period.last).contains(&date),
        };
        is_within(self.first, other) || is_within(other.first, self)
    }

    /// Returns the years, of the first and of the last day, in which the Gregorian calendar has these days.
    ///
    /// The engine takes the days of the week and 29 February from the number of the year. Its runs from after
    /// 29 February of a leap year into the following year are a day short, so such a run begins in a common year.
    pub fn years(self) -> [u32; 2] {
        let (first, passes) = (self.first.month_and_day(), self.passes_new_year());
        let in_first = self.calendar.is_leap() && (!passes || first <= [2, 29]);
        let in_second = self.calendar.is_leap() && !in_first;
        let weekday = self.calendar.weekday(self.first.in_calendar(self.calendar));
        let has_days = |year: &u32| {
            let calendar = Calendar::of_year(*year);
            let begins = calendar.day(first).is_some_and(|day| calendar.weekday(day) == weekday);
            begins && is_leap_year(*year) == in_first && (!passes || is_leap_year(year + 1) == in_second)
        };
        // The days of the week and the leap years recur every 28 years until 2100.
        let year = (FIRST_YEAR..FIRST_YEAR + 28).find(has_days).unwrap_or(FIRST_YEAR);
        [year, year + u32::from(passes)]
    }

    /// Returns year, month and day of the first day, in the first of [`RunPeriod::years`].
    pub fn first_day(self) -> [u32; 3] {
        let [month, day] = self.first.month_and_day();
        [self.years()[0], month, day]
    }

    /// The fields of the engine's `RunPeriod` object. Holidays on weekends, rain and snow are as in the first one of a
    /// model.
    pub(crate) fn to_epjson(self, model: &Model) -> Value {
        let [begin_year, end_year] = self.years();
        let weekday = self.calendar.weekday(self.first.in_calendar(self.calendar));
        let mut fields = json!({
            "begin_month": self.first.month,
            "begin_day_of_month": self.first.day,
            "begin_year": begin_year,
            "end_month": self.last.month,
            "end_day_of_month": self.last.day,
            "end_year": end_year,
            "day_of_week_for_start_day": WEEKDAYS[weekday as usize],
            "use_weather_file_holidays_and_special_days": "No",
            "use_weather_file_daylight_saving_period": "No",
            "apply_weekend_holiday_rule": "No",
            "use_weather_file_rain_indicators": "Yes",
            "use_weather_file_snow_indicators": "Yes",
        });
        for (_, own) in model.objects("RunPeriod").into_iter().take(1) {
            for field in KEPT {
                if let Some(value) = text(own, field) {
                    fields[field] = json!(value);
                }
            }
        }
        fields
    }
}

impl fmt::Display for RunPeriod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, last, .. } = *self;
        match Self::NAMED.into_iter().find(|(_, named)| (named.first, named.last) == (first, last)) {
            Some((name, _)) => f.write_str(name),
            None => write!(f, "{first}..{last}"),
        }
    }
}

impl FromStr for RunPeriod {
    type Err = Error;

    /// Parses `winter`, `summer`, `full_year` or `MM-DD..MM-DD`.
    fn from_str(text: &str) -> Result<Self> {
        if let Some((_, named)) = Self::NAMED.into_iter().find(|(name, _)| *name == text) {
            return Ok(named);
        }
        let (first, last) =
            text.split_once("..").ok_or_else(|| Error::RunPeriod { text: text.to_owned() })?;
        Ok(Self::new(first.parse()?, last.parse()?))
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
    fn a_period_that_passes_new_year_goes_on_in_the_following_year() {
        let period: RunPeriod = "12-27..01-09".parse().unwrap();
        assert_eq!((period.days(), period.to_string().as_str()), (14, "12-27..01-09"));
        assert_eq!([0, 4, 5, 13].map(|after| period.day_of_year(after)), [361, 365, 1, 9]);
        assert_eq!(period.calendar().weekday(1), 0, "1 January 2018 was a Monday");
        assert_eq!((period.years(), period.part(4, 2).to_string().as_str()), ([2017, 2018], "12-31..01-01"));
        assert_eq!(period.first_day(), [2017, 12, 27]);
        let [january, december] = ["01-05..01-12", "12-01..12-26"].map(|text| text.parse().unwrap());
        assert!(period.overlaps(january) && january.overlaps(period) && !period.overlaps(december));
    }

    #[test]
    fn a_leap_year_has_29_february_and_a_run_of_the_engine_has_its_days() {
        let leap = Calendar::new(2, true);
        let of = |text: &str| text.parse::<RunPeriod>().unwrap().in_calendar(leap);
        assert_eq!(
            (of("full_year").days(), of("02-28..03-01").days(), of("02-29..02-29").days()),
            (366, 3, 1)
        );
        assert_eq!(of("winter").date(59).to_string(), "02-29");
        let years =
            ["01-01..01-01", "02-15..01-09", "12-27..01-09", "12-01..03-15"].map(|text| of(text).years());
        for ([year, next], first) in years.into_iter().zip([[1, 1], [2, 15], [12, 27], [12, 1]]) {
            let calendar = Calendar::of_year(year);
            let day = leap.day(first).unwrap();
            assert_eq!(calendar.weekday(calendar.day(first).unwrap()), leap.weekday(day), "{year}");
            assert!(is_leap_year(year) != (is_leap_year(next) && next > year), "{year} {next}");
        }
        assert_eq!(
            "01-01..01-01".parse::<RunPeriod>().unwrap().in_calendar(Calendar::new(3, false)).years(),
            [2026; 2]
        );
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
        for text in ["spring", "02-30..03-01", "0201..0301"] {
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
