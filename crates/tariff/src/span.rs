//! Parts of a year in a tariff: dates, kinds of days, and hours.

use serde::Deserialize;

use crate::calendar::{DAY, Date, date};

/// Ranges of dates, such as `12-01..03-31`, both inclusive; several are separated by commas. A range may cross New
/// Year.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Dates(Vec<(Date, Date)>);

/// Kinds of days.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Days {
    /// All days.
    #[default]
    All,
    /// Monday to Friday without the tariff's holidays.
    Weekdays,
    /// Saturday, Sunday and the tariff's holidays.
    Weekends,
}

/// Hours of a day on the local clock, such as `16-20` or `8:30-12`, at quarter-hours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Hours {
    /// First quarter-hour of the day.
    pub(crate) from: u32,
    /// Quarter-hour after the last.
    pub(crate) to: u32,
}

impl Dates {
    /// Returns whether a day of the year is among the dates.
    pub(crate) fn contain(&self, day: u32) -> bool {
        self.0.iter().any(|(first, last)| match first <= last {
            true => (first.day..=last.day).contains(&day),
            false => day >= first.day || day <= last.day,
        })
    }

    /// Returns all dates of the year.
    pub(crate) fn all() -> Self {
        Self(vec![(Date { day: 1 }, Date { day: 365 })])
    }
}

impl TryFrom<String> for Dates {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let range = |part: &str| {
            let (first, last) = part.split_once("..")?;
            Some((date(first)?, date(last)?))
        };
        let ranges: Option<Vec<_>> = text.split(',').map(range).collect();
        ranges.map(Self).ok_or_else(|| {
            format!("`{text}` is not a range of dates; expected MM-DD..MM-DD, several separated by commas")
        })
    }
}

impl Days {
    /// Returns whether this kind includes weekends and holidays, or weekdays if not `weekend`.
    pub(crate) fn contain(self, weekend: bool) -> bool {
        match self {
            Self::All => true,
            Self::Weekdays => !weekend,
            Self::Weekends => weekend,
        }
    }
}

impl Hours {
    /// Returns the length in hours.
    pub(crate) fn length(self) -> f64 {
        f64::from(self.to - self.from) / 4.0
    }
}

impl TryFrom<String> for Hours {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let parsed = text.split_once('-').and_then(|(from, to)| Some((quarter(from)?, quarter(to)?)));
        let valid = parsed.filter(|(from, to)| from < to && *to <= DAY);
        valid.map(|(from, to)| Self { from, to }).ok_or_else(|| {
            format!(
                "`{text}` is not an hour range; expected H-H from 0 to 24 in a day, such as 16-20 or 8:30-12"
            )
        })
    }
}

/// Returns the quarter-hour of the day of `8` or `8:30`.
fn quarter(text: &str) -> Option<u32> {
    let (hour, minute) = text.trim().split_once(':').unwrap_or((text.trim(), "0"));
    let (hour, minute): (u32, u32) = (hour.parse().ok()?, minute.parse().ok()?);
    (hour <= 24 && minute < 60 && minute % 15 == 0).then_some(hour * 4 + minute / 15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_winter_passes_the_new_year() {
        let winter = Dates::try_from("12-01..03-31".to_owned()).unwrap();
        assert!([1, 90, 335, 365].into_iter().all(|day| winter.contain(day)));
        assert!(![91, 200, 334].into_iter().any(|day| winter.contain(day)));
        assert!(Dates::try_from("12-01".to_owned()).is_err());
    }

    #[test]
    fn hours_are_at_quarter_hours_within_a_day() {
        let hours = |text: &str| Hours::try_from(text.to_owned());
        assert_eq!(hours("8:30-12").unwrap(), Hours { from: 34, to: 48 });
        assert_eq!(hours("20-24").unwrap().length(), 4.0);
        for bad in ["22-6", "8:20-9", "6", "0-25", "10-10"] {
            assert!(hours(bad).is_err(), "{bad}");
        }
    }
}
