//! The calendar of a prepared building.

use std::path::Path;

use b2b_base::calendar::Calendar;
use b2b_climate::Site;

use super::PreparedBuilding;
use crate::hvac::Unsupported;
use crate::import;
use crate::model::Model;
use crate::run_period::{Date, RunPeriod};
use crate::{Error, Result};

/// Returns the calendar of a user's model, which keeps its unsupported systems; `None` for a generated building.
pub(super) fn of(model: &Model, weather: &Path, unsupported: Unsupported) -> Result<Option<Calendar>> {
    match unsupported {
        Unsupported::Refused => Ok(None),
        Unsupported::LeftAlone => Ok(Some(import::calendar::of(model, &Site::read(weather)?))),
    }
}

impl PreparedBuilding {
    /// Returns a run period in the calendar of the building.
    pub fn in_its_calendar(&self, period: RunPeriod) -> RunPeriod {
        period.in_calendar(self.calendar())
    }

    /// Returns the calendar of the building.
    pub fn calendar(&self) -> Calendar {
        self.calendar.unwrap_or_default()
    }

    /// Checks that the building has the days of a run period.
    ///
    /// # Errors
    /// [`Error::PeriodOfCalendar`] for 29 February in a year without it, and for a generated building after New Year.
    pub fn check_period(&self, period: RunPeriod) -> Result<()> {
        let refused =
            |why| Err(Error::PeriodOfCalendar { name: self.name.clone(), period: period.to_string(), why });
        let is_leap_day = |date: Date| date.month_and_day() == [2, 29];
        if !self.calendar().is_leap() && [period.first(), period.last()].into_iter().any(is_leap_day) {
            return refused(
                "its year has no 29 February; only a model of your own in weather with that day has one",
            );
        }
        if self.calendar.is_none() && period.passes_new_year() {
            return refused(
                "a generated building stays in its year of 365 days, and only a model of your own passes New Year; end \
                 the period on 12-31, and begin another on 01-01",
            );
        }
        Ok(())
    }
}
