//! Calendar time of a run, and the seasons of setpoints and clothing.

/// A moment of the run: day of the year from 1, and hour of the day from 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub(crate) day_of_year: u32,
    pub(crate) hour: f64,
}

/// A season, in whole months.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Season {
    /// December to February.
    Winter,
    /// June to August.
    Summer,
    /// The other months.
    Between,
}

impl Season {
    /// The season of a day of the year.
    pub(crate) fn of(day_of_year: u32) -> Self {
        match day_of_year {
            ..60 | 335.. => Self::Winter,
            152..244 => Self::Summer,
            _ => Self::Between,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seasons_are_whole_months() {
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
            assert_eq!(Season::of(day), season, "{day}");
        }
    }
}
