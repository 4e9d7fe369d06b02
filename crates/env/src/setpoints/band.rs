//! Comfort bands: a heating and a cooling setpoint for every controlled zone and time.

use b2b_base::calendar::Calendar;
use b2b_building::{Conditioning, PreparedBuilding, Span, ZoneYear};
use serde::{Deserialize, Serialize};

use crate::limits::within;
use crate::{Error, Result};

/// Minimum gap between heating and cooling setpoint, K (Guideline 36, 5.3.2).
const LEAST_WIDTH: f64 = 0.5;
/// Setpoints that no zone reaches, °C, for one without heating or cooling.
const UNREACHED: [f64; 2] = [0.0, 50.0];

/// The source of a zone's comfort band.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Band {
    /// The schedules of the model's own thermostats. A generated house has the setpoints of a household, drawn by its
    /// id.
    #[default]
    Own,
    /// One pair of setpoints while people are in the zone and one while they are not, [heating, cooling], °C.
    Presence {
        /// While people are present.
        occupied: [f64; 2],
        /// While nobody is present.
        unoccupied: [f64; 2],
    },
    /// Pairs by hours and days of the week; the first that applies.
    Hours {
        /// The pairs.
        pairs: Vec<HoursPair>,
        /// The pair at other times, [heating, cooling], °C.
        otherwise: [f64; 2],
    },
}

/// A pair of setpoints at some hours of some days.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoursPair {
    /// Days of the week.
    #[serde(default)]
    pub days: Days,
    /// First hour of the day.
    pub from: f64,
    /// Hour at which it ends.
    pub to: f64,
    /// [heating, cooling], °C.
    pub pair: [f64; 2],
}

/// Days of the week.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Days {
    /// All days.
    #[default]
    All,
    /// Monday to Friday.
    Weekdays,
    /// Saturday and Sunday.
    Weekends,
}

/// The setpoints of a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Heating setpoint, °C.
    pub heating: f64,
    /// Cooling setpoint, °C; infinite in a zone without cooling.
    pub cooling: f64,
}

/// The next change of a zone's setpoints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextPair {
    /// Hours until then.
    pub hours: f64,
    /// The next setpoints.
    pub pair: Pair,
}

/// The comfort bands of a building's controlled zones under a task, as a building management system would know them.
#[derive(Clone, Debug)]
pub struct Bands {
    band: Band,
    /// Whether people come and go by their schedules.
    scheduled: bool,
    /// The calendar of the episode.
    calendar: Calendar,
    zones: Vec<ZoneBands>,
}

/// A controlled zone and its schedules.
#[derive(Clone, Debug)]
struct ZoneBands {
    year: ZoneYear,
    cooled: bool,
}

impl Band {
    pub(crate) fn check(&self) -> Result<()> {
        let pair = |name, [heating, cooling]: [f64; 2]| {
            within(name, heating, 0.0, 50.0)?;
            within(name, cooling, 0.0, 50.0)?;
            match cooling - heating >= LEAST_WIDTH {
                true => Ok(()),
                false => Err(Error::BandCrosses { name, heating, cooling, least: LEAST_WIDTH }),
            }
        };
        match self {
            Self::Own => Ok(()),
            Self::Presence { occupied, unoccupied } => {
                pair("occupied", *occupied)?;
                pair("unoccupied", *unoccupied)
            }
            Self::Hours { pairs, otherwise } => {
                for HoursPair { from, to, pair: values, .. } in pairs {
                    within("from", *from, 0.0, 24.0)?;
                    within("to", *to, *from, 24.0)?;
                    pair("pair", *values)?;
                }
                pair("otherwise", *otherwise)
            }
        }
    }
}

impl Days {
    fn include(self, calendar: Calendar, day_of_year: u32) -> bool {
        let is_weekend = calendar.weekday(day_of_year) >= 5;
        match self {
            Self::All => true,
            Self::Weekdays => !is_weekend,
            Self::Weekends => is_weekend,
        }
    }
}

impl Bands {
    /// The bands of a building's controlled zones. `scheduled` is whether people come and go by their schedules.
    pub(crate) fn new(band: Band, building: &PreparedBuilding, scheduled: bool, calendar: Calendar) -> Self {
        let zones = building.zones.iter().enumerate();
        let zones = zones.filter(|(_, zone)| zone.conditioning != Conditioning::None).map(|(index, zone)| {
            let cooled = zone.conditioning == Conditioning::HeatingAndCooling;
            ZoneBands { year: building.years.get(index).cloned().unwrap_or_default(), cooled }
        });
        Self { band, scheduled, calendar, zones: zones.collect() }
    }

    /// Returns the setpoints of a controlled zone. `people` is whether any are present; it matters only with pairs by
    /// presence, in zones without schedules and under random presence. An observation has those of the step before.
    pub fn at(&self, zone: usize, day_of_year: u32, hour: f64, people: bool) -> Pair {
        let (zone, day) = (&self.zones[zone], self.calendar.count(day_of_year));
        match &self.band {
            Band::Own if zone.year.is_empty() => zone.pair(UNREACHED),
            Band::Own => zone.of_span(&zone.year.at(day, hour)),
            Band::Presence { occupied, unoccupied } => {
                let known = self.scheduled && !zone.year.is_empty();
                let people = if known { zone.year.at(day, hour).people } else { people };
                zone.pair(if people { *occupied } else { *unoccupied })
            }
            Band::Hours { pairs, otherwise } => {
                zone.pair(self.at_hours(pairs, *otherwise, day_of_year, hour))
            }
        }
    }

    /// Returns the next change of a zone's setpoints within a week, by its schedules.
    pub fn next(&self, zone: usize, day_of_year: u32, hour: f64) -> Option<NextPair> {
        let (zone, day) = (&self.zones[zone], self.calendar.count(day_of_year));
        match &self.band {
            Band::Own | Band::Presence { .. } if zone.year.is_empty() => None,
            Band::Own => {
                let change = zone.year.next_setpoints(day, hour)?;
                Some(NextPair { hours: change.hours, pair: zone.of_span(&change.next) })
            }
            Band::Presence { occupied, unoccupied } => {
                let present = zone.year.at(day, hour).people;
                let change = zone.year.next(day, hour, 7, |span| span.people != present)?;
                let pair = if present { *unoccupied } else { *occupied };
                Some(NextPair { hours: change.hours, pair: zone.pair(pair) })
            }
            Band::Hours { pairs, otherwise } => {
                let now = self.at_hours(pairs, *otherwise, day_of_year, hour);
                let ends = pairs.iter().flat_map(|pair| [pair.from, pair.to]);
                let times = (0..8).flat_map(|day| {
                    ends.clone().chain([0.0]).map(move |end| 24.0 * f64::from(day) + end - hour)
                });
                let change = |hours: f64| self.at_hours(pairs, *otherwise, day_of_year, hour + hours) != now;
                let hours = times.filter(|hours| *hours > 0.0 && change(*hours)).min_by(f64::total_cmp)?;
                let pair = self.at_hours(pairs, *otherwise, day_of_year, hour + hours);
                Some(NextPair { hours, pair: zone.pair(pair) })
            }
        }
    }

    /// Returns the hours until people are in a zone, by its schedules; 0 if they are, `None` if nobody comes within a
    /// week.
    pub fn hours_to_people(&self, zone: usize, day_of_year: u32, hour: f64) -> Option<f64> {
        let (year, day) = (&self.zones[zone].year, self.calendar.count(day_of_year));
        if year.is_empty() { None } else { year.hours_to_people(day, hour) }
    }

    /// Returns the pair of an hour, which may be on a later day.
    fn at_hours(&self, pairs: &[HoursPair], otherwise: [f64; 2], day_of_year: u32, hour: f64) -> [f64; 2] {
        let later = (hour / 24.0).floor();
        let (day, hour) = (self.calendar.after(day_of_year, later as u32), hour - 24.0 * later);
        let applies =
            |pair: &&HoursPair| pair.days.include(self.calendar, day) && (pair.from..pair.to).contains(&hour);
        pairs.iter().find(applies).map_or(otherwise, |pair| pair.pair)
    }
}

impl ZoneBands {
    fn pair(&self, [heating, cooling]: [f64; 2]) -> Pair {
        Pair { heating, cooling: if self.cooled { cooling } else { f64::INFINITY } }
    }

    fn of_span(&self, span: &Span) -> Pair {
        let heating = span.heating.unwrap_or(UNREACHED[0]);
        let cooling = span.cooling.unwrap_or(UNREACHED[1]);
        // A thermostat with one setpoint has no band: it holds a temperature.
        self.pair([heating.min(cooling), cooling])
    }
}

impl Pair {
    /// Returns the deviation of a temperature from the band, K: negative below, 0 within.
    pub fn deviation(&self, temperature: f64) -> f64 {
        if temperature < self.heating {
            temperature - self.heating
        } else if temperature > self.cooling {
            temperature - self.cooling
        } else {
            0.0
        }
    }

    /// The temperature in the middle, °C; the heating setpoint in a zone without cooling.
    pub fn middle(&self) -> f64 {
        if self.cooling.is_finite() { 0.5 * (self.heating + self.cooling) } else { self.heating }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn office(band: Band) -> Bands {
        let year = ZoneYear::default();
        let zone = |cooled| ZoneBands { year: year.clone(), cooled };
        Bands { band, scheduled: true, calendar: Calendar::default(), zones: vec![zone(true), zone(false)] }
    }

    fn weekdays() -> Band {
        let pair = HoursPair { days: Days::Weekdays, from: 6.0, to: 18.0, pair: [21.0, 24.0] };
        Band::Hours { pairs: vec![pair], otherwise: [15.6, 28.0] }
    }

    #[test]
    fn pairs_by_hours_change_at_their_hours_and_days() {
        let bands = office(weekdays());
        // Day 6 is a Friday.
        let at = |day, hour| bands.at(0, day, hour, false).heating;
        assert_eq!([at(6, 5.9), at(6, 6.0), at(6, 17.9), at(6, 18.0)], [15.6, 21.0, 21.0, 15.6]);
        assert_eq!(at(7, 12.0), 15.6);
        assert_eq!(bands.at(1, 6, 12.0, true).cooling, f64::INFINITY);
        // 1 January 2018 is a Monday, and the day after 31 December 2017.
        let passing = Bands { calendar: Calendar::default().passing_new_year(361), ..office(weekdays()) };
        assert_eq!(passing.at(0, 1, 12.0, false).heating, 21.0);
        assert_eq!(passing.next(0, 365, 12.0).map(|next| next.hours), Some(18.0));
    }

    #[test]
    fn pairs_by_presence_follow_the_schedules_of_a_zone_or_else_the_people_seen() {
        let span =
            |from, people| format!(r#"{{"from":{from},"heating":null,"cooling":null,"people":{people}}}"#);
        let spans = [span(0, false), span(6, true), span(18, false)].join(",");
        let year: ZoneYear =
            serde_json::from_str(&format!(r#"{{"profiles":[[{spans}]],"days":[0]}}"#)).unwrap();
        let band = Band::Presence { occupied: [21.0, 24.0], unoccupied: [15.6, 28.0] };
        let zones = [year, ZoneYear::default()].map(|year| ZoneBands { year, cooled: true });
        let mut bands = Bands { band, scheduled: true, calendar: Calendar::default(), zones: zones.into() };
        let heating = |zone, hour, people| bands.at(zone, 1, hour, people).heating;
        assert_eq!(
            [heating(0, 5.9, true), heating(0, 6.0, false), heating(0, 18.0, true)],
            [15.6, 21.0, 15.6]
        );
        assert_eq!([heating(1, 12.0, false), heating(1, 0.0, true)], [15.6, 21.0]);
        bands.scheduled = false;
        assert_eq!(bands.at(0, 1, 12.0, false).heating, 15.6, "random presence");
    }

    #[test]
    fn a_temperature_deviates_from_the_nearer_setpoint() {
        let pair = Pair { heating: 21.0, cooling: 24.0 };
        assert_eq!([20.0, 22.0, 26.0].map(|temperature| pair.deviation(temperature)), [-1.0, 0.0, 2.0]);
        assert_eq!(pair.middle(), 22.5);
        assert_eq!(Pair { cooling: f64::INFINITY, ..pair }.middle(), 21.0);
    }

    #[test]
    fn a_band_that_crosses_is_an_error_with_its_name() {
        let said = |band: Band| band.check().unwrap_err().to_string();
        let crossed = said(Band::Presence { occupied: [24.0, 21.0], unoccupied: [15.0, 30.0] });
        assert!(
            crossed.contains("occupied") && crossed.contains("24") && crossed.contains("21"),
            "{crossed}"
        );
        let narrow = said(Band::Hours { pairs: Vec::new(), otherwise: [21.0, 21.2] });
        assert!(narrow.contains("otherwise") && narrow.contains("0.5"), "{narrow}");
    }
}
