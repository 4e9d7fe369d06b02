//! Supervisory values by day and block of the day.

use serde::{Deserialize, Serialize};

use crate::guideline36::{Shift, SupervisoryPoint};
use crate::{Error, Result};

/// Hours of a day.
const DAY: u32 = 24;
/// Values are rounded to hundredths of their unit, so that a file holds what was run.
const PER_UNIT: f64 = 100.0;

/// Shifts of the values that Guideline 36 chooses, by block of each day.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Schedule {
    /// Names of the shifts: of a kind, for all zones and systems, such as `earlier start`, or of one point.
    pub shifts: Vec<String>,
    /// Length of a block, h; a divisor of 24.
    pub block_hours: u32,
    /// The days of the episode in order, each with its blocks from midnight on, each with one value per shift.
    pub days: Vec<Vec<Vec<f64>>>,
}

/// A shift that a schedule varies.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Varied {
    pub(super) name: String,
    pub(super) kind: &'static str,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Unit of the search.
    pub(super) unit: f64,
}

impl Varied {
    /// Returns the shifts of a building: those of every point, or each kind once, in order of appearance. Setpoints
    /// stay within the band: outside, they only trade comfort for cost.
    pub(super) fn of(points: &[SupervisoryPoint], by_zone: bool) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for point in points {
            let (kind, _) = point.shift.described();
            let name = if by_zone { &point.name } else { kind };
            let [low, high] = match point.shift {
                Shift::HeatingSetpoint => [0.0, point.high],
                Shift::CoolingSetpoint => [point.low, 0.0],
                _ => [point.low, point.high],
            };
            if all.iter().all(|varied| varied.name != name) {
                all.push(Self { name: name.to_owned(), kind, low, high, unit: point.high.min(-point.low) });
            }
        }
        all
    }

    /// Returns the kinds of shifts, each once.
    pub(super) fn kinds(all: &[Self]) -> Vec<&'static str> {
        let mut kinds: Vec<&str> = Vec::new();
        for varied in all {
            if !kinds.contains(&varied.kind) {
                kinds.push(varied.kind);
            }
        }
        kinds
    }
}

impl Schedule {
    /// Returns the number of blocks of a day.
    fn blocks(block_hours: u32) -> usize {
        (DAY / block_hours) as usize
    }

    /// Returns the schedule of a search's point: for each day, the blocks one after another, in units of the shifts.
    pub(super) fn of_point(varied: &[Varied], block_hours: u32, point: &[Vec<f64>]) -> Self {
        let value = |(varied, share): (&Varied, &f64)| {
            let value = (share * varied.unit).clamp(varied.low, varied.high);
            // Adding 0 turns a negative zero into a positive one.
            (value * PER_UNIT).round() / PER_UNIT + 0.0
        };
        let block = |shares: &[f64]| varied.iter().zip(shares).map(value).collect();
        Self {
            shifts: varied.iter().map(|varied| varied.name.clone()).collect(),
            block_hours,
            days: point.iter().map(|day| day.chunks(varied.len()).map(block).collect()).collect(),
        }
    }

    /// Returns the positions of each kind of shift in a search's day.
    pub(super) fn parts(varied: &[Varied], block_hours: u32) -> Vec<Vec<usize>> {
        let length = varied.len() * Self::blocks(block_hours);
        let of = |kind| (0..length).filter(|index| varied[index % varied.len()].kind == kind).collect();
        Varied::kinds(varied).into_iter().map(of).collect()
    }

    /// Returns the bounds of a search's day.
    pub(super) fn bounds(varied: &[Varied], block_hours: u32) -> Vec<[f64; 2]> {
        let of = |varied: &Varied| [varied.low, varied.high].map(|limit| limit / varied.unit);
        let block: Vec<_> = varied.iter().map(of).collect();
        block.repeat(Self::blocks(block_hours))
    }

    /// Checks the shape, and that all values are finite.
    ///
    /// # Errors
    /// [`Error::Values`] with what is wrong.
    pub fn check(&self) -> Result<()> {
        let wrong = |why: String| Err(Error::Values { why });
        let Self { shifts, block_hours, days } = self;
        if !DAY.is_multiple_of(*block_hours) {
            return wrong(format!("block_hours is {block_hours}; expected a divisor of 24"));
        }
        if days.is_empty() {
            return wrong("`days` is empty".to_owned());
        }
        let blocks = Self::blocks(*block_hours);
        for (number, day) in days.iter().enumerate() {
            if day.len() != blocks || day.iter().any(|block| block.len() != shifts.len()) {
                return wrong(format!(
                    "day {number} does not have {blocks} blocks with a value for each of {} shifts",
                    shifts.len()
                ));
            }
        }
        match days.iter().flatten().flatten().find(|value| !value.is_finite()) {
            Some(value) => wrong(format!("{value} is not a finite number")),
            None => Ok(()),
        }
    }

    /// Returns the values of the points of a building, one row per block of the episode.
    ///
    /// # Errors
    /// [`Error::Values`] if [`Schedule::check`] fails, a point's shift is missing, or a shift has no point.
    pub(super) fn rows(&self, points: &[SupervisoryPoint]) -> Result<Vec<Vec<f64>>> {
        self.check()?;
        let number = |point: &SupervisoryPoint| {
            let (kind, _) = point.shift.described();
            let name = &point.name;
            let missing = || Error::Values { why: format!("the schedule has neither `{kind}` nor `{name}`") };
            self.shifts.iter().position(|shift| shift == kind || shift == name).ok_or_else(missing)
        };
        let numbers = points.iter().map(number).collect::<Result<Vec<_>>>()?;
        if let Some(unused) = (0..self.shifts.len()).find(|number| !numbers.contains(number)) {
            let why = format!("`{}` of the schedule shifts no point of the building", self.shifts[unused]);
            return Err(Error::Values { why });
        }
        let row = |block: &Vec<f64>| numbers.iter().map(|&number| block[number]).collect();
        Ok(self.days.iter().flatten().map(row).collect())
    }
}

#[cfg(test)]
mod tests {
    use b2b_building::morphology::Owner;

    use super::*;

    fn varied() -> [Varied; 2] {
        [("a", -0.5, 2.0, 0.5), ("b", -0.1, 0.3, 0.1)].map(|(kind, low, high, unit)| Varied {
            name: kind.to_owned(),
            kind,
            low,
            high,
            unit,
        })
    }

    #[test]
    fn a_point_of_the_search_becomes_values_within_the_limits() {
        let day = [vec![1.0, 9.0], vec![-2.0, 0.0]].concat();
        let schedule = Schedule::of_point(&varied(), 12, &[day]);
        assert_eq!(schedule.days, [[[0.5, 0.3], [-0.5, 0.0]]]);
        schedule.check().unwrap();
        let bounds = Schedule::bounds(&varied(), 12);
        assert_eq!((bounds.len(), bounds[0]), (4, [-1.0, 4.0]));
        assert!((bounds[3][0] + 1.0).abs() < 1e-12 && (bounds[3][1] - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_schedule_by_zone_sets_every_point_and_leaves_out_a_kind_at_a_time() {
        let point = |name: &str, shift| SupervisoryPoint {
            name: name.to_owned(),
            owner: Owner::Zone(0),
            shift,
            unit: "K",
            low: -1.0,
            high: 1.0,
        };
        let points = [
            point("A heating setpoint shift", Shift::HeatingSetpoint),
            point("A cooling setpoint shift", Shift::CoolingSetpoint),
            point("B heating setpoint shift", Shift::HeatingSetpoint),
        ];
        let all = Varied::of(&points, true);
        assert_eq!(Varied::of(&points, false).len(), 2);
        assert_eq!(Varied::kinds(&all), ["heating setpoint shift", "cooling setpoint shift"]);
        assert_eq!(Schedule::parts(&all, 12), [vec![0, 2, 3, 5], vec![1, 4]]);
        let schedule = Schedule::of_point(&all, 12, &[vec![0.1, -0.2, 0.3, 0.4, -0.5, 0.6]]);
        assert_eq!(schedule.rows(&points).unwrap(), [[0.1, -0.2, 0.3], [0.4, -0.5, 0.6]]);
        let said = schedule.rows(&[point("C earlier start", Shift::Start)]).unwrap_err().to_string();
        assert!(said.contains("neither `earlier start` nor `C earlier start`"), "{said}");
        let said = schedule.rows(&points[..2]).unwrap_err().to_string();
        assert!(said.contains("`B heating setpoint shift` of the schedule shifts no point"), "{said}");
    }

    #[test]
    fn a_schedule_of_another_shape_is_refused() {
        let good = Schedule::of_point(&varied(), 12, &[vec![0.0; 4]]);
        let said = |change: fn(&mut Schedule)| {
            let mut bad = good.clone();
            change(&mut bad);
            bad.check().unwrap_err().to_string()
        };
        assert!(said(|bad| bad.block_hours = 5).contains("divisor of 24"));
        assert!(said(|bad| bad.days.clear()).contains("empty"));
        assert!(said(|bad| bad.days[0].truncate(1)).contains("2 blocks"));
        assert!(said(|bad| bad.days[0][1][0] = f64::NAN).contains("finite"));
    }
}
