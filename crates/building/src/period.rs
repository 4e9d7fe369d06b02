//! The period of an episode as given by a user: days of the year, or two weeks chosen from the weather.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use b2b_climate::{EpwFile, TWO_WEEKS, TwoWeeks};
use serde::{Deserialize, Serialize};

use crate::{Date, Error, Result, RunPeriod};

/// Days of the year, or [two weeks](TwoWeeks) chosen from a building's weather.
///
/// Serialized as text, for example `winter`, `01-01..03-31` or `peak-heating`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Period {
    /// Days of the year.
    Days(RunPeriod),
    /// Two weeks of a weather file.
    TwoWeeks(TwoWeeks),
}

impl Period {
    /// Winter, as in the paper.
    pub const WINTER: Self = Self::Days(RunPeriod::WINTER);

    /// Number of days.
    pub fn days(self) -> u32 {
        match self {
            Self::Days(period) => period.days(),
            Self::TwoWeeks(_) => TWO_WEEKS as u32,
        }
    }

    /// Returns the days of the year in a weather file.
    ///
    /// # Errors
    /// [`Error::Climate`] when the file cannot be read; [`Error::NotOneYear`] when it does not cover a year.
    pub fn in_weather(self, weather: &Path) -> Result<RunPeriod> {
        let two_weeks = match self {
            Self::Days(period) => return Ok(period),
            Self::TwoWeeks(two_weeks) => two_weeks,
        };
        let file = EpwFile::open(weather)?;
        let record = file.record()?;
        let hourly = Some(record.dry_bulbs()).filter(|_| record.is_whole_year());
        let first = hourly.and_then(|hourly| two_weeks.first_day(&hourly));
        let first = first.ok_or_else(|| Error::NotOneYear { weather: weather.to_owned() })?;
        Ok(RunPeriod::new(Date::of_day(first), Date::of_day(first + TWO_WEEKS as u32 - 1)))
    }
}

impl From<RunPeriod> for Period {
    fn from(period: RunPeriod) -> Self {
        Self::Days(period)
    }
}

impl fmt::Display for Period {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Days(period) => period.fmt(f),
            Self::TwoWeeks(two_weeks) => two_weeks.fmt(f),
        }
    }
}

impl FromStr for Period {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text.parse() {
            Ok(two_weeks) => Ok(Self::TwoWeeks(two_weeks)),
            Err(()) => text.parse().map(Self::Days).map_err(|error| match error {
                Error::RunPeriod { text } => Error::Period { text },
                other => other,
            }),
        }
    }
}

impl TryFrom<String> for Period {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Period> for String {
    fn from(period: Period) -> Self {
        period.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_is_its_text() {
        for text in ["winter", "summer", "02-03..02-10", "peak-heating", "mixed"] {
            assert_eq!(text.parse::<Period>().unwrap().to_string(), text);
        }
        assert_eq!("typical-cooling".parse::<Period>().unwrap().days(), 14);
        let said = "peak-heatin".parse::<Period>().unwrap_err().to_string();
        assert!(said.contains("peak-heating") && said.contains("MM-DD"), "{said}");
    }
}
