//! Cost of an episode's energy under its tariff, and emissions under its profile.

use std::path::Path;

use b2b_base::calendar::Calendar;
use b2b_building::{Carrier, CarrierEnergy, RunPeriod};
use b2b_climate::EpwFile;
use b2b_tariff::{Bill, Emissions, Moment, Part, Prices};

use crate::engine_report::BillPart;
use crate::spaces::EpisodeConfig;
use crate::task::Task;
use crate::{Error, Result};

/// The bill of an episode and its prices.
#[derive(Clone, Debug)]
pub(crate) struct Billing {
    prices: Option<Prices>,
    emissions: Option<Emissions>,
    bill: Bill,
    period: RunPeriod,
    /// m².
    floor_area: f64,
    /// Length of a step, h.
    hours: f64,
}

/// Cost and emissions of a step, where a tariff or a profile determines them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Billed {
    /// Cost, currency/m².
    pub cost: Option<f64>,
    /// Emissions, g CO₂/m².
    pub emissions: Option<f64>,
}

impl Billing {
    /// Returns the bill of an episode in a building with this floor area, m²; without tariff and profile it bills
    /// nothing.
    ///
    /// # Errors
    /// [`Error::Tariff`]; [`Error::Building`] if the weather file cannot be read.
    pub(crate) fn new(episode: &EpisodeConfig, floor_area: f64) -> Result<Self> {
        let EpisodeConfig { weather, period, steps_per_hour, task } = episode;
        let emissions = task.emission_profile.as_ref().map(|profile| profile.emissions());
        Ok(Self {
            prices: prices(task, weather, period.calendar())?,
            emissions: emissions.transpose()?,
            bill: Self::empty(*period),
            period: *period,
            floor_area,
            hours: 1.0 / f64::from(*steps_per_hour),
        })
    }

    fn empty(period: RunPeriod) -> Bill {
        Bill::new(period.day_of_year(0), period.last_day_of_year())
    }

    /// Begins an episode.
    pub(crate) fn restart(&mut self) {
        self.bill = Self::empty(self.period);
    }

    /// Adds a step that began at a moment, with its energy, Wh/m².
    pub(crate) fn step(&mut self, day_of_year: u32, hour: f64, energy: &CarrierEnergy) -> Billed {
        let at = Moment { day: day_of_year, hour };
        let kwh = energy.map(|energy| energy.max(0.0) * self.floor_area / 1000.0);
        let cost = self
            .prices
            .as_ref()
            .map(|prices| self.bill.step(prices, at, &kwh, self.hours).total() / self.floor_area);
        let in_common_year = Moment { day: self.period.calendar().day_of_common_year(day_of_year), hour };
        let emitted = |profile: &Emissions| {
            let carriers = Carrier::ALL.into_iter().zip(energy);
            // kg/kWh is g/Wh.
            carriers.map(|(fuel, energy)| profile.at(fuel, in_common_year) * energy).sum()
        };
        Billed { cost, emissions: self.emissions.as_ref().map(emitted) }
    }

    /// Writes the electricity prices of the hours ahead, currency/kWh, as known at a moment. Returns whether there are
    /// any.
    pub(crate) fn preview(
        &self,
        day_of_year: u32,
        hour: f64,
        ahead: &mut [f64; b2b_tariff::PREVIEW],
    ) -> bool {
        let at = Moment { day: day_of_year, hour };
        let Some(prices) = &self.prices else { return false };
        prices.preview(at, self.bill.block(prices, at), ahead);
        true
    }

    /// Returns the parts of the bill so far; none without a tariff.
    pub(crate) fn parts(&self) -> Vec<BillPart> {
        let part =
            |Part { name, quantity, unit, cost }| BillPart { name, quantity, unit: unit.to_owned(), cost };
        let parts = self.prices.as_ref().map(|prices| self.bill.parts(prices));
        parts.into_iter().flatten().map(part).collect()
    }
}

/// Returns the prices of a task's tariff in a calendar, with the weather of a file; `None` without a tariff.
fn prices(task: &Task, weather: &Path, calendar: Calendar) -> Result<Option<Prices>> {
    let Some(tariff) = &task.tariff else { return Ok(None) };
    let tariff = tariff.tariff()?;
    let file = EpwFile::open(weather).map_err(Error::building)?;
    let outdoor = file.record().map_err(Error::building)?.dry_bulbs_in(calendar);
    let events =
        if tariff.has_events() { tariff.events(calendar, &daily_means(&outdoor)) } else { Vec::new() };
    let outdoor = Some(outdoor.as_slice()).filter(|_| tariff.needs_temperatures());
    Ok(Some(Prices::new(tariff, calendar, &events, outdoor)?))
}

/// The price of electricity in the steps of an episode.
#[derive(Clone, Debug, PartialEq)]
pub struct ElectricityPrice {
    /// Currency; `None` where the task gives prices without one.
    pub currency: Option<String>,
    /// Price at the beginning of each step, currency/kWh; the first block's price if the tariff has blocks.
    pub steps: Vec<f64>,
}

impl ElectricityPrice {
    /// Returns the price in the steps of an episode, from the tariff or the prices of its task.
    ///
    /// # Errors
    /// [`Error::Tariff`]; [`Error::Building`] if the weather file cannot be read.
    pub fn of(episode: &EpisodeConfig) -> Result<Self> {
        let EpisodeConfig { weather, period, steps_per_hour, task } = episode;
        let prices = prices(task, weather, period.calendar())?;
        let per_day = 24 * *steps_per_hour as usize;
        let steps = (0..episode.steps()).map(|step| {
            let day = period.day_of_year((step / per_day) as u32);
            let hour = (step % per_day) as f64 / f64::from(*steps_per_hour);
            match &prices {
                Some(prices) => prices.electricity(Moment { day, hour }, 0),
                None => task.prices.electricity.at(hour),
            }
        });
        Ok(Self { steps: steps.collect(), currency: task.currency()? })
    }
}

/// The daily means of a year's hourly temperatures.
fn daily_means(hourly: &[f64]) -> Vec<f64> {
    hourly.chunks(24).map(|day| day.iter().sum::<f64>() / day.len() as f64).collect()
}
