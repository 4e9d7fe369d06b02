//! The calendar of an episode.

use serde::{Deserialize, Serialize};

/// Days of the months of a common year.
pub const MONTH_DAYS: [u32; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
/// The last day of February in a common year, counted from 1 January.
const FEBRUARY_28: u32 = 59;

/// The calendar of an episode: the day of the week of 1 January, whether there is a 29 February, and the first day of
/// an episode that spans New Year.
///
/// Days of the year are counted from 1. In an episode that spans New Year, days before its first day belong to the
/// following year, and the day of the week continues as in EnergyPlus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Calendar {
    /// Day of the week of 1 January, 0 (Monday) to 6 (Sunday).
    new_year: u32,
    leap: bool,
    /// First day of an episode that spans New Year; otherwise 1.
    first_day: u32,
}

impl Default for Calendar {
    /// Returns the calendar of 2017, a common year that begins on a Sunday, which every generated building has.
    fn default() -> Self {
        Self::new(6, false)
    }
}

impl Calendar {
    /// Returns the calendar of a year of the Gregorian calendar.
    pub const fn of_year(year: u32) -> Self {
        Self::new(weekday_of_new_year(year), is_leap_year(year))
    }

    /// Returns the calendar of a year that begins on a day of the week, 0 (Monday) to 6 (Sunday), with or without 29
    /// February.
    pub const fn new(new_year: u32, leap: bool) -> Self {
        Self { new_year: new_year % 7, leap, first_day: 1 }
    }

    /// Returns the calendar of an episode of this year that begins on a day and spans New Year.
    #[must_use]
    pub const fn passing_new_year(self, first_day: u32) -> Self {
        Self { first_day, ..self }
    }

    /// Returns the calendar of the year in which the episode begins.
    #[must_use]
    pub const fn first_year(self) -> Self {
        Self { first_day: 1, ..self }
    }

    /// Returns the calendar of the following year, which has a 29 February if this one does.
    #[must_use]
    pub const fn following(self) -> Self {
        Self::new(self.new_year + self.days(), self.leap)
    }

    /// Returns the calendar of the whole year in which a day of the episode lies.
    #[must_use]
    pub const fn year_of(self, day: u32) -> Self {
        if day < self.first_day { self.following() } else { self.first_year() }
    }

    /// Returns whether there is a 29 February.
    pub const fn is_leap(self) -> bool {
        self.leap
    }

    /// Returns the number of days of the year, 365 or 366.
    pub const fn days(self) -> u32 {
        365 + self.leap as u32
    }

    /// Returns the number of a day of the year, counted from 1 January of the year in which the episode begins.
    pub const fn count(self, day: u32) -> u32 {
        if day < self.first_day { day + self.days() } else { day }
    }

    /// Returns the day of the year that is some days after another.
    pub const fn after(self, day: u32, days: u32) -> u32 {
        (day - 1 + days) % self.days() + 1
    }

    /// Returns the day of the week, 0 (Monday) to 6 (Sunday), of a day of the year.
    pub const fn weekday(self, day: u32) -> u32 {
        (self.new_year + self.count(day) - 1) % 7
    }

    /// Returns the day of a common year with the same date, 1 to 365; 29 February counts as 28 February.
    pub const fn day_of_common_year(self, day: u32) -> u32 {
        day - (self.leap && day > FEBRUARY_28) as u32
    }

    /// Returns the number of days of a month, 0 to 11.
    pub const fn month_days(self, month: usize) -> u32 {
        MONTH_DAYS[month] + (self.leap && month == 1) as u32
    }

    /// Returns the day of the year on which a month, 0 to 11, begins.
    pub fn month_start(self, month: usize) -> u32 {
        (0..month).map(|before| self.month_days(before)).sum::<u32>() + 1
    }

    /// Returns the month, 0 to 11, of a day of the year.
    pub fn month_of(self, day: u32) -> usize {
        (1..12).take_while(|month| self.month_start(*month) <= day).count()
    }

    /// Returns the month and the day of the month, both from 1, of a day of the year.
    pub fn date(self, day: u32) -> [u32; 2] {
        let month = self.month_of(day);
        [month as u32 + 1, day - self.month_start(month) + 1]
    }

    /// Returns the day of the year of a month and a day of the month, both from 1; `None` if there is no such date.
    pub fn day(self, [month, day]: [u32; 2]) -> Option<u32> {
        let month = (month as usize).checked_sub(1).filter(|month| *month < 12)?;
        (1..=self.month_days(month)).contains(&day).then(|| self.month_start(month) + day - 1)
    }
}

/// Returns the day of the week of 1 January, 0 (Monday) to 6 (Sunday), of a year of the Gregorian calendar.
pub const fn weekday_of_new_year(year: u32) -> u32 {
    // 1 January of the year 1 was a Monday.
    let before = year.saturating_sub(1);
    (before + before / 4 - before / 100 + before / 400) % 7
}

/// Returns whether a year of the Gregorian calendar has a 29 February.
pub const fn is_leap_year(year: u32) -> bool {
    year.is_multiple_of(4) && !year.is_multiple_of(100) || year.is_multiple_of(400)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn years_have_the_weekdays_and_the_leap_days_of_the_gregorian_calendar() {
        assert_eq!([2017, 2018, 2020, 2024].map(weekday_of_new_year), [6, 0, 2, 0]);
        assert_eq!([1900, 2000, 2017, 2020].map(is_leap_year), [false, true, false, true]);
    }

    #[test]
    fn every_day_has_one_date_and_29_february_exists_only_in_leap_years() {
        for calendar in [Calendar::default(), Calendar::new(2, true)] {
            for day in 1..=calendar.days() {
                assert_eq!(calendar.day(calendar.date(day)), Some(day));
            }
        }
        let leap = Calendar::new(2, true);
        assert_eq!((leap.day([2, 29]), Calendar::default().day([2, 29])), (Some(60), None));
        assert_eq!([59, 60, 61, 366].map(|day| leap.day_of_common_year(day)), [59, 59, 60, 365]);
        assert_eq!(leap.weekday(60), 5, "29 February 2020 was a Saturday");
        assert_eq!((leap.day([13, 1]), leap.day([0, 1]), leap.day([4, 31])), (None, None, None));
    }

    #[test]
    fn days_of_the_week_go_on_after_new_year() {
        let winter = Calendar::default().passing_new_year(361);
        assert_eq!(winter.weekday(361), 2, "27 December 2017 was a Wednesday");
        assert_eq!([365, 1, 9].map(|day| winter.weekday(day)), [6, 0, 1], "1 January 2018 was a Monday");
        assert_eq!((winter.after(365, 1), winter.count(1)), (1, 366));
        assert_eq!(Calendar::default().following().weekday(1), 0);
    }
}
