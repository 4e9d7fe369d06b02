//! Energy prices of a tariff by day of the year, kind of day and quarter-hour.

use toml::Spanned;

use crate::calendar::{DAY, DAYS, Date};
use crate::error::Fault;
use crate::file::{EnergyFile, MAX_BLOCKS, MAX_NAMES, Price};
use crate::span::Hours;

/// A quarter-hour without a price.
const NONE: u16 = u16::MAX;

/// Prices that apply at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Class {
    /// Index of its name in the table.
    pub(crate) name: usize,
    /// Price of each block per kWh.
    pub(crate) prices: [f64; MAX_BLOCKS],
    /// Whether the energy counts toward the blocks.
    pub(crate) counts: bool,
}

/// The energy prices of a tariff.
#[derive(Clone, Debug)]
pub(crate) struct EnergyTable {
    /// Names of prices on a bill.
    pub(crate) names: Vec<String>,
    pub(crate) classes: Vec<Class>,
    /// Whether any entry has `hourly` prices.
    pub(crate) is_hourly: bool,
    /// Class by day of the year, kind of day and quarter-hour on the local clock.
    grid: Vec<u16>,
}

impl Class {
    /// Returns the class of one price in all blocks, without a name yet.
    pub(crate) fn flat(price: f64, counts: bool) -> Self {
        Self { name: 0, prices: [price; MAX_BLOCKS], counts }
    }
}

/// Returns the index of a day of the year, kind of day and quarter-hour of the day.
fn index(day: u32, weekend: bool, quarter: u32) -> usize {
    (((day - 1) * 2 + u32::from(weekend)) * DAY + quarter) as usize
}

impl EnergyTable {
    /// Lays out the energy prices of a file, in `blocks` blocks each. Entries with `hours` or `hourly` come first; the
    /// others fill the rest.
    ///
    /// # Errors
    /// A fault if an entry is wrong, or if a time has two prices or none.
    pub(crate) fn of(entries: &[Spanned<EnergyFile>], blocks: usize, place: usize) -> Result<Self, Fault> {
        let grid = vec![NONE; index(DAYS + 1, false, 0)];
        let is_hourly = entries.iter().any(|entry| entry.get_ref().hourly.is_some());
        let mut table = Self { names: Vec::new(), classes: Vec::new(), is_hourly, grid };
        let (rest, timed): (Vec<_>, Vec<_>) = entries.iter().partition(|entry| is_rest(entry.get_ref()));
        for entry in timed {
            table.put(entry, blocks, &[])?;
        }
        let taken = table.grid.clone();
        for entry in rest {
            table.put(entry, blocks, &taken)?;
        }
        table.check_complete(entries.first().map_or(place, |entry| entry.span().start))?;
        Ok(table)
    }

    /// Returns the class at a day of the year, kind of day and quarter-hour of the day.
    pub(crate) fn at(&self, day: u32, weekend: bool, quarter: u32) -> u16 {
        self.grid[index(day, weekend, quarter)]
    }

    /// Adds a class under a name and returns its index.
    ///
    /// # Errors
    /// A fault at a place for prices that are negative or not finite, and for too many names or classes.
    pub(crate) fn add(&mut self, name: &str, class: Class, place: usize) -> Result<u16, Fault> {
        if let Some(price) = class.prices.into_iter().find(|price| !price.is_finite() || *price < 0.0) {
            let why = format!(
                "the price of `{name}` is {price}; expected a number of at least 0 (only `hourly` prices of a market may be \
                 negative)"
            );
            return Err(Fault::at(place, why));
        }
        self.add_unchecked(name, class, place)
    }

    fn add_unchecked(&mut self, name: &str, class: Class, place: usize) -> Result<u16, Fault> {
        let known = self.names.iter().position(|known| known == name);
        let name = known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        if self.names.len() > MAX_NAMES {
            let why = format!("more than {MAX_NAMES} names of energy prices; give seasons the same name");
            return Err(Fault::at(place, why));
        }
        self.classes.push(Class { name, ..class });
        let index = u16::try_from(self.classes.len() - 1).ok().filter(|index| *index != NONE);
        index.ok_or_else(|| Fault::at(place, "more than 65,000 energy prices"))
    }

    /// Puts an entry at its times. An entry with neither `hours` nor `hourly` skips times in `taken`.
    fn put(&mut self, entry: &Spanned<EnergyFile>, blocks: usize, taken: &[u16]) -> Result<(), Fault> {
        let place = entry.span().start;
        let entry = entry.get_ref();
        let first = self.add_entry(entry, blocks, place)?;
        let whole = [Hours { from: 0, to: DAY }];
        let hours = entry.hours.as_deref().unwrap_or(&whole);
        let mut is_used = false;
        for (day, weekend) in (1..=DAYS).flat_map(|day| [(day, false), (day, true)]) {
            if !(entry.dates.contain(day) && entry.days.contain(weekend)) {
                continue;
            }
            for quarter in hours.iter().flat_map(|hours| hours.from..hours.to) {
                let at = index(day, weekend, quarter);
                let class = first + if entry.hourly.is_some() { (quarter / 4) as u16 } else { 0 };
                if self.grid[at] == NONE {
                    self.grid[at] = class;
                    is_used = true;
                } else if !is_rest(entry) || taken[at] == NONE {
                    let other = &self.names[self.classes[usize::from(self.grid[at])].name];
                    let when = when(day, weekend, quarter);
                    let why = format!("`{}` has a second price on {when}, beside `{other}`", entry.name);
                    return Err(Fault::at(place, why));
                }
            }
        }
        if !is_used {
            let why = format!("`{}` is the price of no time; give it `hours`, or remove it", entry.name);
            return Err(Fault::at(place, why));
        }
        Ok(())
    }

    /// Adds the classes of an entry and returns the first: one, or one for each hour.
    fn add_entry(&mut self, entry: &EnergyFile, blocks: usize, place: usize) -> Result<u16, Fault> {
        let fault = |why: String| Fault::at(place, format!("`{}` {why}", entry.name));
        match (&entry.price, &entry.hourly) {
            (Some(Price::One(price)), None) => self.add(&entry.name, Class::flat(*price, true), place),
            (Some(Price::Blocks(prices)), None) if prices.len() == blocks => {
                let mut class = Class::flat(prices[blocks - 1], true);
                class.prices[..blocks].copy_from_slice(prices);
                self.add(&entry.name, class, place)
            }
            (Some(Price::Blocks(prices)), None) => Err(fault(format!(
                "has {} prices for {blocks} blocks; give one for each block of [electricity.blocks]",
                prices.len()
            ))),
            (None, Some(hourly)) if hourly.len() == 24 && entry.hours.is_none() => {
                if let Some(price) = hourly.iter().find(|price| !price.is_finite()) {
                    return Err(fault(format!("has the hourly price {price}; expected numbers")));
                }
                let mut added = hourly
                    .iter()
                    .map(|price| self.add_unchecked(&entry.name, Class::flat(*price, true), place));
                let first = added.next().expect("there are 24")?;
                added.try_for_each(|class| class.map(|_| ()))?;
                Ok(first)
            }
            (None, Some(_)) => Err(fault("has `hourly`; expected 24 prices and no `hours`".into())),
            _ => Err(fault("needs either `price` or `hourly`".into())),
        }
    }

    fn check_complete(&self, place: usize) -> Result<(), Fault> {
        let Some(missing) = self.grid.iter().position(|class| *class == NONE) else { return Ok(()) };
        let of_day = 2 * DAY as usize;
        let lacks = |day: usize| self.grid[day * of_day..(day + 1) * of_day].contains(&NONE);
        let first = missing / of_day;
        let last = (first..DAYS as usize).take_while(|day| lacks(*day)).last().unwrap_or(first);
        let (weekend, quarter) = (missing / DAY as usize % 2 == 1, missing % DAY as usize);
        let why = format!(
            "no energy price from {} to {}; add an [[electricity.energy]] for it, or one without `hours` for the rest of \
             its dates",
            when(first as u32 + 1, weekend, quarter as u32),
            Date { day: last as u32 + 1 }
        );
        Err(Fault::at(place, why))
    }
}

/// Returns whether an entry fills the times that entries with `hours` or `hourly` leave.
fn is_rest(entry: &EnergyFile) -> bool {
    entry.hours.is_none() && entry.hourly.is_none()
}

/// Returns a time as text for an error.
fn when(day: u32, weekend: bool, quarter: u32) -> String {
    let kind = if weekend { "weekends" } else { "weekdays" };
    format!("{} ({kind}, {}:{:02})", Date { day }, quarter / 4, quarter % 4 * 15)
}
