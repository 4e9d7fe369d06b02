//! Calendar time of a run, and the seasons of setpoints and clothing.

use std::path::Path;

use b2b_base::calendar::Calendar;
use b2b_climate::EpwFile;

use crate::{Error, Result};

/// A moment of the run: day of the year from 1, and hour of the day from 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub(crate) day_of_year: u32,
    pub(crate) hour: f64,
}

/// A season, in whole months.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Season {
    /// December to February; south of the equator, June to August.
    Winter,
    /// June to August; south of the equator, December to February.
    Summer,
    /// The other months.
    Between,
}

/// The seasons of a site.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seasons {
    is_south: bool,
    calendar: Calendar,
}

impl Seasons {
    /// Returns the seasons of the site of a weather file in a calendar.
    ///
    /// # Errors
    /// [`Error::Building`] if the file cannot be read.
    pub(crate) fn of(weather: &Path, calendar: Calendar) -> Result<Self> {
        let site = EpwFile::open(weather).and_then(|file| file.site()).map_err(Error::building)?;
        Ok(Self { is_south: site.latitude < 0.0, calendar })
    }

    /// Returns the season of a day of the year.
    pub(crate) fn on(self, day_of_year: u32) -> Season {
        match self.calendar.day_of_common_year(day_of_year) {
            ..60 | 335.. if self.is_south => Season::Summer,
            ..60 | 335.. => Season::Winter,
            152..244 if self.is_south => Season::Winter,
            152..244 => Season::Summer,
            _ => Season::Between,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seasons_are_whole_months_and_opposite_in_the_south() {
        let (north, south) = (Seasons::default(), Seasons { is_south: true, ..Seasons::default() });
        for (day, season) in [
            (1, Season::Winter),
            (59, Season::Winter),
            (60, Season::Between),
            (151, Season::Between),
            (152, Season::Summer),
            (243, Season::Summer),
            (244, Season::Between),
            (334, Season::Between),
            (335, Season::Winter),
        ] {
            assert_eq!(north.on(day), season, "{day}");
            let opposite = match season {
                Season::Winter => Season::Summer,
                Season::Summer => Season::Winter,
                Season::Between => Season::Between,
            };
            assert_eq!(south.on(day), opposite, "{day}");
        }
    }
}
