//! The prices of a calendar year: a tariff laid out by quarter-hour on the clock of the simulation.

use b2b_base::calendar::Calendar;
use b2b_base::carrier::{Carrier, CarrierEnergy};

use crate::calendar::{DAY, Moment, advance, quarters};
use crate::energy::Class;
use crate::error::{Error, Result};
use crate::events::{Event, EventRule};
use crate::tariff::Tariff;

/// Hours of a preview.
pub const PREVIEW: usize = 24;

/// The prices of a tariff in the calendar of an episode. Looking up a price does not allocate.
#[derive(Clone, Debug)]
pub struct Prices {
    pub(crate) tariff: Tariff,
    /// Class by quarter-hour of the year in standard time, without events.
    usual: Box<[u16]>,
    /// Class by quarter-hour, with events.
    classes: Box<[u16]>,
    /// Demand charges that apply, one bit each, by quarter-hour.
    charges: Box<[u8]>,
    pub(crate) calendar: Calendar,
}

impl Prices {
    /// Lays out a tariff in the calendar of an episode.
    ///
    /// `outdoor` holds the outdoor temperatures in °C of all hours of the year in standard time; only tariffs with a
    /// cold-weather price need them.
    ///
    /// # Errors
    /// [`Error::Inputs`] for missing temperatures or the wrong number of them, and for an event outside the year.
    pub fn new(
        tariff: Tariff,
        calendar: Calendar,
        events: &[Event],
        outdoor: Option<&[f64]>,
    ) -> Result<Self> {
        let inputs = |why: String| Error::Inputs { tariff: tariff.name.clone(), why };
        let days = calendar.days();
        let hours = days as usize * 24;
        match outdoor {
            None if tariff.needs_temperatures() => {
                return Err(inputs(
                    "has a cold-weather price; give the outdoor temperatures of the year".into(),
                ));
            }
            Some(given) if given.len() != hours => {
                return Err(inputs(format!("got {} outdoor temperatures; expected {hours}", given.len())));
            }
            _ => {}
        }
        if let Some(event) = events.iter().find(|event| !(1..=days).contains(&event.day)) {
            return Err(inputs(format!("got an event on day {}; expected 1 to {days}", event.day)));
        }
        let quarters = quarters(calendar);
        let mut usual = vec![0; quarters].into_boxed_slice();
        let mut charges = vec![0; quarters].into_boxed_slice();
        let weekends: Vec<bool> = (1..=days).map(|day| tariff.is_weekend(calendar, day)).collect();
        for standard in 0..quarters as u32 {
            let (day, quarter) = local(&tariff, calendar, standard);
            let weekend = weekends[day as usize - 1];
            let day = calendar.day_of_common_year(day);
            let at = standard as usize;
            usual[at] = tariff.energy.at(day, weekend, quarter);
            if let (Some(cold), Some(outdoor)) = (tariff.cold, outdoor)
                && outdoor[at / 4] < cold.below
            {
                usual[at] = cold.class;
            }
            let applying =
                tariff.charges.iter().enumerate().filter(|(_, charge)| charge.applies(day, weekend, quarter));
            charges[at] = applying.fold(0, |bits, (bit, _)| bits | 1 << bit);
        }
        let mut classes = usual.clone();
        if let Some(rule) = &tariff.events {
            put_events(&mut classes, rule, events, |standard| local(&tariff, calendar, standard));
        }
        Ok(Self { tariff, usual, classes, charges, calendar })
    }

    /// Returns the tariff.
    pub fn tariff(&self) -> &Tariff {
        &self.tariff
    }

    /// Returns the price of electricity per kWh at a moment, in a block of energy (0 is the first).
    pub fn electricity(&self, at: Moment, block: usize) -> f64 {
        self.class(self.quarter(at)).price(block)
    }

    /// Returns the price per kWh of a carrier at a moment, for electricity in the first block.
    pub fn price(&self, fuel: Carrier, at: Moment) -> f64 {
        self.tariff.fuels.at(fuel, self.electricity(at, 0))
    }

    /// Writes the price of electricity per kWh now and in 1 to 23 hours, in a block of energy, as known now: an event
    /// only from its notice on, cold-weather prices by the actual future weather. The end of the year is followed by
    /// its beginning.
    pub fn preview(&self, now: Moment, block: usize, ahead: &mut [f64; PREVIEW]) {
        let now = self.quarter(now);
        for (hours, price) in ahead.iter_mut().enumerate() {
            let at = (now + hours * 4) % self.quarters();
            let class = if self.is_known(now, at) { self.classes[at] } else { self.usual[at] };
            *price = self.tariff.energy.classes[usize::from(class)].price(block);
        }
    }

    /// Returns whether an event applies at a moment.
    pub fn is_event(&self, at: Moment) -> bool {
        let at = self.quarter(at);
        self.classes[at] != self.usual[at]
    }

    /// Returns whether the price at quarter-hour `at` of the year is known at quarter-hour `now`. Only the price of an
    /// event that has not been announced is not.
    fn is_known(&self, now: usize, at: usize) -> bool {
        let Some(rule) = self.tariff.events.as_ref().filter(|_| self.classes[at] != self.usual[at]) else {
            return true;
        };
        let (today, quarter) = local(&self.tariff, self.calendar, now as u32);
        let (day, _) = local(&self.tariff, self.calendar, at as u32);
        let days_ahead = (day + self.calendar.days() - today) % self.calendar.days();
        days_ahead == 0 || days_ahead == 1 && f64::from(quarter) / 4.0 >= rule.notice
    }

    /// Returns the quarter-hour of the year of a moment.
    pub(crate) fn quarter(&self, at: Moment) -> usize {
        // Hours are sums of steps, so half a second counts as rounding.
        ((at.quarters() + 5e-4) as usize) % self.quarters()
    }

    /// Returns the number of quarter-hours in the year.
    pub(crate) fn quarters(&self) -> usize {
        self.classes.len()
    }

    /// Returns the prices at a quarter-hour of the year.
    pub(crate) fn class(&self, quarter: usize) -> &Class {
        &self.tariff.energy.classes[usize::from(self.classes[quarter])]
    }

    /// Returns the demand charges that apply at a quarter-hour of the year, one bit each.
    pub(crate) fn charges_at(&self, quarter: usize) -> u8 {
        self.charges[quarter]
    }

    /// Returns the prices of all carriers for a given price of electricity.
    pub(crate) fn of_fuels(&self, electricity: f64) -> CarrierEnergy {
        Carrier::ALL.map(|fuel| self.tariff.fuels.at(fuel, electricity))
    }
}

impl Class {
    /// Returns the price per kWh in a block.
    pub(crate) fn price(&self, block: usize) -> f64 {
        self.prices[block.min(self.prices.len() - 1)]
    }
}

/// Converts a quarter-hour of the year in standard time to the day of the year and the quarter-hour of the day on the
/// tariff's clock.
fn local(tariff: &Tariff, calendar: Calendar, standard: u32) -> (u32, u32) {
    let advance = if tariff.daylight_time { advance(calendar, standard) } else { 0 };
    let quarter = (standard + advance) % quarters(calendar) as u32;
    (quarter / DAY + 1, quarter % DAY)
}

fn put_events(classes: &mut [u16], rule: &EventRule, events: &[Event], local: impl Fn(u32) -> (u32, u32)) {
    for (standard, class) in classes.iter_mut().enumerate() {
        let (day, quarter) = local(standard as u32);
        let hour = f64::from(quarter) / 4.0;
        if events.iter().any(|event| event.day == day && (event.from..event.to).contains(&hour)) {
            *class = rule.class;
        }
    }
}
