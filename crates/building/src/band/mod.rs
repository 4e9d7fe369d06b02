//! Comfort bands of zones: the heating and cooling setpoints of a building's own thermostats, and when people are
//! present.
//!
//! - [`ZoneYear`] is the year of a zone according to its own schedules.
//! - A house's thermostats have no setpoints: `household` draws its bands from surveys.

mod household;
mod schedules;
mod thermostat;

pub use household::UNNAMED_HOUSE;

use b2b_base::calendar::Calendar;
use b2b_energyplus::Library;
use serde::{Deserialize, Serialize};

use crate::people::{PeopleGroup, least_in_use};
use crate::{Model, Result};
use thermostat::Thermostat;

/// A zone's setpoints and presence during a part of a day.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// Hour of the day at which it begins.
    pub from: f64,
    /// Heating setpoint, °C; `None` without heating.
    pub heating: Option<f64>,
    /// Cooling setpoint, °C; `None` without cooling.
    pub cooling: Option<f64>,
    /// Whether people use the zone, as [`least_in_use`] defines.
    pub people: bool,
}

/// The days of a zone's schedules: setpoints of its thermostat, and presence of people. A generated building has one
/// year, a user's model two, of which the second follows the first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ZoneYear {
    /// The different days, each a sequence of spans from hour 0.
    profiles: Vec<Vec<Span>>,
    /// The profile of every day, counted from 1 January of the first year.
    days: Vec<u16>,
}

/// The next change in a zone's schedules.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Hours until then.
    pub hours: f64,
    /// The span that follows.
    pub next: Span,
}

impl ZoneYear {
    /// Compresses values at regular times, `per_day` on each of `days` days.
    pub(crate) fn of_samples(days: usize, per_day: usize, at: impl Fn(usize) -> Span) -> Self {
        let mut year = Self::default();
        for day in 0..days {
            let mut spans: Vec<Span> = Vec::new();
            for number in 0..per_day {
                let from = 24.0 * number as f64 / per_day as f64;
                let span = Span { from, ..at(day * per_day + number) };
                if spans.last().is_none_or(|last| !last.asks_the_same(&span)) {
                    spans.push(span);
                }
            }
            let known = year.profiles.iter().position(|profile| *profile == spans);
            let index = known.unwrap_or_else(|| {
                year.profiles.push(spans);
                year.profiles.len() - 1
            });
            year.days.push(index as u16);
        }
        year
    }

    /// Returns whether nothing is known about the zone.
    pub fn is_empty(&self) -> bool {
        self.days.is_empty()
    }

    /// Returns the span of a day (from 1 on 1 January of the first year) and an hour of the day. Hours may be past the
    /// end of the day.
    ///
    /// # Panics
    /// If the year is empty.
    pub fn at(&self, day: u32, hour: f64) -> Span {
        let (day, hour) = day_and_hour(day, hour);
        let spans = self.day(day);
        *spans.iter().rev().find(|span| span.from <= hour).unwrap_or(&spans[0])
    }

    /// Returns the next span, within `days` days, that satisfies a condition.
    pub fn next(&self, day: u32, hour: f64, days: u32, condition: impl Fn(&Span) -> bool) -> Option<Change> {
        let (first, hour) = day_and_hour(day, hour);
        (0..=days).find_map(|later| {
            let start = 24.0 * f64::from(later) - hour;
            let spans = self.day(first + i64::from(later)).iter();
            let mut ahead = spans.map(|span| Change { hours: start + span.from, next: *span });
            ahead.find(|change| change.hours > 0.0 && condition(&change.next))
        })
    }

    /// Returns the next change of the setpoints within a week.
    pub fn next_setpoints(&self, day: u32, hour: f64) -> Option<Change> {
        let now = self.at(day, hour);
        self.next(day, hour, 7, |span| (span.heating, span.cooling) != (now.heating, now.cooling))
    }

    /// Returns the hours until people are present, within a week; 0 if they are.
    pub fn hours_to_people(&self, day: u32, hour: f64) -> Option<f64> {
        if self.at(day, hour).people {
            return Some(0.0);
        }
        self.next(day, hour, 7, |span| span.people).map(|change| change.hours)
    }

    /// Returns all different spans.
    pub fn spans(&self) -> impl Iterator<Item = &Span> {
        self.profiles.iter().flatten()
    }

    /// Returns the spans of a day, from 1 on 1 January of the first year.
    pub fn spans_of(&self, day: u32) -> &[Span] {
        self.day(i64::from(day) - 1)
    }

    /// Returns the spans of a day from 0; after the last day the first one follows.
    fn day(&self, day: i64) -> &[Span] {
        &self.profiles[usize::from(self.days[day.rem_euclid(self.days.len() as i64) as usize])]
    }
}

impl Span {
    fn asks_the_same(&self, other: &Self) -> bool {
        Self { from: other.from, ..*self } == *other
    }
}

/// The day from 0 and the hour within the day.
fn day_and_hour(day: u32, hour: f64) -> (i64, f64) {
    let days = (hour / 24.0).floor();
    (i64::from(day) - 1 + days as i64, hour - 24.0 * days)
}

/// The years of a building's schedules.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Year {
    /// The zones, in the given order.
    pub(crate) zones: Vec<ZoneYear>,
    /// Days, from 1 on 1 January of the first year and in order, that the model declares special, such as holidays.
    pub(crate) holidays: Vec<u32>,
    /// When each switch is off.
    pub(crate) off: Vec<Off>,
}

/// When a schedule is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Off {
    /// Share of the time.
    pub(crate) share: f64,
    /// Share of each month of the first year, January first.
    pub(crate) by_month: [f64; 12],
}

/// Returns the years of zones and of switches, which are names of schedules, according to the schedules of a model. The
/// setpoints of a house are drawn from surveys, with the name of the building as the seed.
///
/// A user's model has the year of its calendar and the following one; a generated building, which has no calendar, one
/// default year.
///
/// # Errors
/// [`crate::Error::Engine`] when the engine rejects a schedule; the errors of [`crate::people::groups`].
pub(crate) fn year(
    building: &str,
    model: &Model,
    zones: &[&str],
    switches: &[&str],
    calendar: Option<Calendar>,
    library: &Library,
) -> Result<Year> {
    let thermostats: Vec<_> = zones.iter().map(|zone| Thermostat::of(model, zone)).collect();
    let people = crate::people::groups(model)?;
    let of_zone = |zone: &&str| -> Vec<&PeopleGroup> {
        people.iter().filter(|group| group.people > 0.0 && group.zone.eq_ignore_ascii_case(zone)).collect()
    };
    let present: Vec<_> = zones.iter().map(of_zone).collect();
    let mut names: Vec<&str> = thermostats.iter().flatten().flat_map(Thermostat::schedules).collect();
    names.extend(present.iter().flatten().map(|group| group.schedule.as_str()));
    names.extend(switches);
    let years = calendar.map_or(vec![Calendar::default()], |year| vec![year, year.following()]);
    let days: u32 = years.iter().map(|year| year.days()).sum();
    let sampled = schedules::Sampled::of(model, &names, &years, library)?;
    let least = zones.iter().map(|zone| least_in_use(model, &people, zone)).collect::<Result<Vec<_>>>()?;
    let zones = thermostats.iter().zip(&present).zip(least).map(|((thermostat, present), least)| {
        let setpoints = thermostat.as_ref().map(|thermostat| thermostat.setpoints(&sampled));
        let present = present.iter().map(|group| (group.people, sampled.of_schedule(&group.schedule)));
        let present: Vec<_> = present.collect();
        ZoneYear::of_samples(days as usize, schedules::PER_DAY, |index| {
            let [heating, cooling] = setpoints.as_ref().map_or([None; 2], |setpoints| setpoints(index));
            let people: f64 = present.iter().map(|(people, share)| people * share.at(index)).sum();
            Span { from: 0.0, heating, cooling, people: people > 0.0 && people >= least }
        })
    });
    let zones = household::furnish(household::name(building, model), zones.collect());
    let off = switches.iter().map(|name| sampled.of_schedule(name).share_off(years[0])).collect();
    Ok(Year { zones, off, holidays: sampled.into_holidays() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weekdays 21 to 24 °C from 6 to 18 h, otherwise 15 to 30 °C; people from 8 to 17 h. Day 1 is a Sunday.
    fn office() -> ZoneYear {
        ZoneYear::of_samples(365, 96, |index| {
            let (day, hour) = (index / 96, (index % 96) as f64 / 4.0);
            let weekday = !matches!(day % 7, 0 | 6);
            let open = weekday && (6.0..18.0).contains(&hour);
            let [heating, cooling] = if open { [21.0, 24.0] } else { [15.0, 30.0] };
            let people = weekday && (8.0..17.0).contains(&hour);
            Span { from: 0.0, heating: Some(heating), cooling: Some(cooling), people }
        })
    }

    #[test]
    fn a_year_stores_each_different_day_once() {
        let year = office();
        assert_eq!(year.profiles.len(), 2);
        assert_eq!(year.spans().count(), 1 + 5);
        assert_eq!(year.at(2, 5.99).heating, Some(15.0));
        assert_eq!(year.at(2, 6.0).heating, Some(21.0));
        assert!(!year.at(2, 7.99).people && year.at(2, 8.0).people);
        assert_eq!(year.at(1, 24.0 + 6.0), year.at(2, 6.0));
        assert_eq!(year.at(365, 24.0 + 6.0), year.at(1, 6.0), "the year begins anew");
    }

    #[test]
    fn the_next_change_is_found_across_the_weekend() {
        let year = office();
        let change = year.next_setpoints(6, 19.0).unwrap();
        assert_eq!((change.hours, change.next.heating), (5.0 + 48.0 + 6.0, Some(21.0)));
        assert_eq!(year.hours_to_people(6, 17.0), Some(7.0 + 48.0 + 8.0));
        assert_eq!(year.hours_to_people(6, 9.0), Some(0.0));
        let constant = ZoneYear::of_samples(365, 96, |_| Span {
            from: 0.0,
            heating: Some(10.0),
            cooling: None,
            people: false,
        });
        assert_eq!(constant.next_setpoints(1, 0.0), None);
        assert_eq!(constant.hours_to_people(1, 0.0), None);
    }
}
