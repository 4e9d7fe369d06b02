//! A tariff: the content of a file, checked and laid out by day, kind of day and quarter-hour.

use std::path::Path;

use b2b_base::calendar::Calendar;
use toml::Spanned;

use crate::calendar::{Holiday, is_on};
use crate::charge::{Charge, charges};
use crate::energy::{Class, EnergyTable};
use crate::error::{Fault, Result, read};
use crate::events::{Event, EventRule};
use crate::file::{
    BlocksFile, ColdFile, Customers, ElectricityFile, EnergyFile, MAX_BLOCKS, Per, Price, Source, TariffFile,
};
use crate::fuel::FuelValues;

/// A tariff.
#[derive(Clone, Debug)]
pub struct Tariff {
    /// Name of a shipped tariff, such as `hq-d`, or of the file without its extension.
    pub name: String,
    /// The utility, and its name for the tariff.
    pub title: String,
    /// Where it applies.
    pub place: String,
    /// Customers that it is for.
    pub customers: Customers,
    /// Currency of all prices, such as `USD`.
    pub currency: String,
    /// Where the figures come from.
    pub source: Source,
    pub(crate) energy: EnergyTable,
    pub(crate) blocks: Blocks,
    pub(crate) charges: Vec<Charge>,
    pub(crate) events: Option<EventRule>,
    pub(crate) cold: Option<Cold>,
    pub(crate) fuels: FuelValues,
    pub(crate) holidays: Vec<Holiday>,
    pub(crate) daylight_time: bool,
    pub(crate) month_days: Option<u32>,
}

/// Blocks of energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks {
    pub(crate) per: Per,
    /// kWh at which each block ends; infinite for the last.
    pub(crate) up_to: [f64; MAX_BLOCKS],
    /// Number of blocks.
    pub(crate) count: usize,
}

/// The price in cold weather.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cold {
    /// Outdoor temperature below which it applies, °C.
    pub(crate) below: f64,
    /// Its class.
    pub(crate) class: u16,
}

impl Tariff {
    /// Reads a tariff from a TOML file.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::File`](crate::Error::File) with the line, if the file is not a tariff.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Self::parse(&name, &path.display().to_string(), &read(path)?)
    }

    /// Returns the tariff of a TOML text. Errors name it `file`.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File) with the line.
    pub fn parse(name: &str, file: &str, text: &str) -> Result<Self> {
        Self::of_text(name, text).map_err(|fault| fault.of(file, text))
    }

    fn of_text(name: &str, text: &str) -> Result<Self, Fault> {
        let file: TariffFile = toml::from_str(text)?;
        let (place, electricity) = (file.electricity.span().start, file.electricity.into_inner());
        let blocks = Blocks::of(electricity.blocks.as_ref())?;
        let mut energy = EnergyTable::of(&electricity.energy, blocks.count, place)?;
        let has_list = |entry: &Spanned<EnergyFile>| matches!(entry.get_ref().price, Some(Price::Blocks(_)));
        if let Some(file) = electricity.blocks.as_ref().filter(|_| !electricity.energy.iter().any(has_list)) {
            let why = "[electricity.blocks] has no effect: no `price` is a list with one for each block";
            return Err(Fault::at(file.span().start, why));
        }
        let events = electricity.events.as_ref();
        let events = events.map(|events| EventRule::of(events, &mut energy)).transpose()?;
        let cold = electricity.cold.as_ref();
        let cold = cold.map(|cold| Cold::of(cold, &mut energy)).transpose()?;
        Ok(Self {
            name: name.to_owned(),
            title: file.title,
            place: file.place,
            customers: file.customers,
            currency: file.currency,
            source: file.source,
            blocks,
            charges: charges(&electricity.demand)?,
            events,
            cold,
            fuels: FuelValues::PRICES.with(file.fuels.as_ref(), None)?,
            month_days: month_days(&electricity, place)?,
            energy,
            holidays: electricity.holidays,
            daylight_time: electricity.daylight_time,
        })
    }

    /// Returns whether events may be called.
    pub fn has_events(&self) -> bool {
        self.events.is_some()
    }

    /// Chooses the events of a year from its daily mean outdoor temperatures, °C.
    ///
    /// The permitted times of the coldest permitted days become events, within the number per day and the hours per
    /// winter that the tariff allows. January to March and December of the year count as one winter. In order
    /// of time; a tariff without events has none.
    pub fn events(&self, calendar: Calendar, daily_means: &[f64]) -> Vec<Event> {
        let Some(rule) = &self.events else { return Vec::new() };
        rule.choose(calendar, daily_means, |day| self.is_weekend(calendar, day))
    }

    /// Returns whether a day of a year is a Saturday, a Sunday or one of the tariff's holidays.
    pub(crate) fn is_weekend(&self, calendar: Calendar, day: u32) -> bool {
        calendar.weekday(day) >= 5 || self.holidays.iter().any(|holiday| is_on(*holiday, calendar, day))
    }

    /// Returns whether a price depends on the outdoor temperature.
    pub fn needs_temperatures(&self) -> bool {
        self.cold.is_some()
    }

    /// Returns the parts of the bill as text, such as `2 energy prices`, `blocks`, `demand charge`.
    pub fn traits(&self) -> Vec<String> {
        let prices =
            self.energy.names.len() - usize::from(self.events.is_some()) - usize::from(self.cold.is_some());
        let energy = match prices {
            _ if self.energy.is_hourly => "hourly prices".into(),
            1 => "one energy price".into(),
            _ => format!("{prices} energy prices"),
        };
        let has_ratchet = self.charges.iter().any(|charge| charge.ratchet.is_some());
        let others = [
            (self.blocks.count > 1, "blocks"),
            (self.has_demand_charge(), "demand charge"),
            (has_ratchet, "ratchet"),
            (self.events.is_some(), "winter events"),
            (self.cold.is_some(), "a price while it is cold"),
        ];
        let others = others.into_iter().filter(|(has, _)| *has).map(|(_, word)| word.to_owned());
        std::iter::once(energy).chain(others).collect()
    }

    /// Returns whether peaks are billed.
    pub fn has_demand_charge(&self) -> bool {
        !self.charges.is_empty()
    }
}

fn month_days(electricity: &ElectricityFile, place: usize) -> Result<Option<u32>, Fault> {
    match electricity.month_days {
        Some(days) if !(28..=31).contains(&days) => {
            Err(Fault::at(place, format!("`month_days` is {days}; expected 28 to 31, or leave it out")))
        }
        days => Ok(days),
    }
}

impl Blocks {
    fn of(file: Option<&Spanned<BlocksFile>>) -> Result<Self, Fault> {
        let mut up_to = [f64::INFINITY; MAX_BLOCKS];
        let Some(file) = file else { return Ok(Self { per: Per::Month, up_to, count: 1 }) };
        let given = &file.get_ref().up_to;
        let rising =
            given.iter().all(|end| end.is_finite() && *end > 0.0) && given.is_sorted_by(|a, b| a < b);
        if given.is_empty() || given.len() >= MAX_BLOCKS || !rising {
            let why =
                format!("`up_to` is {given:?}; expected one to {} rising numbers of kWh", MAX_BLOCKS - 1);
            return Err(Fault::at(file.span().start, why));
        }
        up_to[..given.len()].copy_from_slice(given);
        Ok(Self { per: file.get_ref().per, up_to, count: given.len() + 1 })
    }
}

impl Cold {
    fn of(file: &Spanned<ColdFile>, energy: &mut EnergyTable) -> Result<Self, Fault> {
        let place = file.span().start;
        let file = file.get_ref();
        if !file.below.is_finite() {
            return Err(Fault::at(place, format!("`below` is {}; expected a temperature in °C", file.below)));
        }
        let class = energy.add("cold", Class::flat(file.price, true), place)?;
        Ok(Self { below: file.below, class })
    }
}
