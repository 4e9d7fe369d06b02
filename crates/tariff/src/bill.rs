//! The bill of an episode, kept up to date step by step.

use b2b_base::calendar::Calendar;
use b2b_base::carrier::{Carrier, CarrierEnergy};

use crate::calendar::Moment;
use crate::charge::Charge;
use crate::energy::Class;
use crate::fuel::label;

use crate::file::{MAX_CHARGES, MAX_NAMES, Per};
use crate::prices::Prices;
use crate::tariff::Blocks;

/// Part of a quarter-hour that counts as rounding: half a second.
const ROUNDING: f64 = 5e-4;

/// The bill of an episode. It holds no references and allocates nothing, so a copy continues like the original.
///
/// Monthly charges, and monthly blocks of energy, are billed by the share of a month's days that the episode covers:
/// two weeks do not pay a whole month's peak. A ratchet only knows the peaks within the episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bill {
    first_day: u32,
    last_day: u32,
    /// Day of the year and month of the last step; 0 before the first.
    day: u32,
    month: usize,
    /// kWh that count for the blocks, this day or month.
    block_energy: f64,
    /// Index of the current quarter-hour, and its kWh so far.
    quarter: usize,
    quarter_energy: f64,
    /// Largest quarter-hour mean of the month of each charge, kW.
    peaks: [f64; MAX_CHARGES],
    /// Largest one of the episode on the ratchet's dates, kW.
    ratchets: [f64; MAX_CHARGES],
    /// Share of the current month's days that each charge covers.
    shares: [f64; MAX_CHARGES],
    closed: [Amount; MAX_CHARGES],
    energy: [Amount; MAX_NAMES],
    fuels: [Amount; Carrier::ALL.len()],
}

/// A quantity and its cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Amount {
    quantity: f64,
    cost: f64,
}

/// The cost of a step in the tariff's currency.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepCost {
    /// Energy of all carriers.
    pub energy: f64,
    /// Increase of the demand charges.
    pub demand: f64,
}

/// A part of a bill.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name of a price of the tariff, a demand charge or a carrier.
    pub name: String,
    /// kWh for energy; for a demand charge, the largest kW billed in a month.
    pub quantity: f64,
    /// `kWh` or `kW`.
    pub unit: &'static str,
    /// Cost in the tariff's currency.
    pub cost: f64,
}

impl StepCost {
    /// Returns the sum.
    pub fn total(self) -> f64 {
        self.energy + self.demand
    }
}

impl Bill {
    /// Returns the empty bill of an episode from a first to a last day of the year, both inclusive. An episode that
    /// passes New Year has the last day before the first.
    pub fn new(first_day: u32, last_day: u32) -> Self {
        Self {
            first_day,
            last_day,
            day: 0,
            month: 0,
            block_energy: 0.0,
            quarter: usize::MAX,
            quarter_energy: 0.0,
            peaks: [0.0; MAX_CHARGES],
            ratchets: [0.0; MAX_CHARGES],
            shares: [0.0; MAX_CHARGES],
            closed: [Amount::default(); MAX_CHARGES],
            energy: [Amount::default(); MAX_NAMES],
            fuels: [Amount::default(); Carrier::ALL.len()],
        }
    }

    /// Adds a step that begins at a moment and lasts some hours, with the energy of each carrier in kWh (none
    /// negative), and returns its cost. Power is constant during a step. Steps must come in order of time.
    ///
    /// The demand charge of a step is the increase of the bill so far, so that the steps sum up to the bill. At the
    /// first step of a month, it can be the part that a ratchet bills in any case.
    pub fn step(&mut self, prices: &Prices, at: Moment, energy: &CarrierEnergy, hours: f64) -> StepCost {
        let before = self.demand(prices);
        let (mut from, end) = (at.quarters(), at.quarters() + hours * 4.0);
        let (mut cost, length) = (0.0, end - from);
        while end - from > ROUNDING {
            let index = (from + ROUNDING) as usize;
            let to = if end - (index + 1) as f64 > ROUNDING { (index + 1) as f64 } else { end };
            cost += self.add(prices, index % prices.quarters(), (to - from) / length, energy);
            from = to;
        }
        StepCost { energy: cost, demand: self.demand(prices) - before }
    }

    /// Returns the block of energy that the next kWh is in, 0 for the first.
    pub fn block(&self, prices: &Prices, at: Moment) -> usize {
        let blocks = &prices.tariff.blocks;
        let day = (prices.quarter(at) / 96) as u32 + 1;
        if self.day == 0 || is_reset(blocks, prices.calendar, self.day, day) {
            return 0;
        }
        let limit = self.scale(prices, day);
        blocks.up_to[..blocks.count - 1].iter().filter(|end| **end * limit <= self.block_energy).count()
    }

    /// Returns the mean power of a quarter-hour, kW, up to which no demand charge grows at a moment: the lowest peak
    /// that is already billed or free, over the charges that apply. Infinite if none applies.
    pub fn free_power(&self, prices: &Prices, at: Moment) -> f64 {
        let applying = prices.charges_at(prices.quarter(at));
        let is_new_month = self.day == 0 || prices.calendar.month_of(at.day) != self.month;
        let charges =
            prices.tariff.charges.iter().enumerate().filter(|(index, _)| applying & 1 << index != 0);
        let free = charges.map(|(index, charge)| {
            let peak = |index: usize| if is_new_month { 0.0 } else { self.peaks[index] };
            let subtracted = (0..MAX_CHARGES).filter(|other| charge.excess_over & 1 << other != 0).map(peak);
            peak(index).max(self.least(charge, index)).max(charge.above + subtracted.fold(0.0, f64::max))
        });
        free.fold(f64::INFINITY, f64::min)
    }

    /// Returns the cost of the episode so far.
    pub fn total(&self, prices: &Prices) -> f64 {
        let energy = self.energy.iter().chain(&self.fuels).map(|amount| amount.cost).sum::<f64>();
        energy + self.demand(prices)
    }

    /// Returns the parts of the bill: electricity by the names of its prices, demand charges, other carriers. Those of
    /// one name and unit are one part; parts without a quantity are left out.
    pub fn parts(&self, prices: &Prices) -> Vec<Part> {
        let mut parts: Vec<Part> = Vec::new();
        let mut put = |name: &str, amount: Amount, unit: &'static str| {
            let known = parts.iter_mut().find(|part| part.unit == unit && part.name == name);
            match known {
                Some(part) => {
                    part.quantity = match unit {
                        "kW" => part.quantity.max(amount.quantity),
                        _ => part.quantity + amount.quantity,
                    };
                    part.cost += amount.cost;
                }
                None if amount.quantity != 0.0 => {
                    let Amount { quantity, cost } = amount;
                    parts.push(Part { name: name.to_owned(), quantity, unit, cost });
                }
                None => {}
            }
        };
        prices
            .tariff
            .energy
            .names
            .iter()
            .zip(self.energy)
            .for_each(|(name, amount)| put(name, amount, "kWh"));
        for (index, charge) in prices.tariff.charges.iter().enumerate() {
            let (closed, now) = (self.closed[index], self.charge(prices, index));
            let quantity = closed.quantity.max(now.quantity);
            put(&charge.name, Amount { quantity, cost: closed.cost + now.cost }, "kW");
        }
        Carrier::ALL.iter().zip(self.fuels).for_each(|(fuel, amount)| put(label(*fuel), amount, "kWh"));
        parts
    }

    /// Adds a share of a step within one quarter-hour of the year and returns the cost of its energy.
    fn add(&mut self, prices: &Prices, quarter: usize, share: f64, energy: &CarrierEnergy) -> f64 {
        self.enter((quarter / 96) as u32 + 1, prices);
        let class = prices.class(quarter);
        let electricity = energy[Carrier::Electricity as usize] * share;
        let mut cost = self.electricity(prices, class, electricity);
        self.energy[class.name].quantity += electricity;
        self.energy[class.name].cost += cost;
        let fuel_prices = prices.of_fuels(class.price(0));
        for (index, price) in fuel_prices.into_iter().enumerate().skip(1) {
            let amount = energy[index] * share;
            self.fuels[index].quantity += amount;
            self.fuels[index].cost += amount * price;
            cost += amount * price;
        }
        self.measure(prices, quarter, electricity);
        cost
    }

    /// Returns the cost of electricity by blocks.
    fn electricity(&mut self, prices: &Prices, class: &Class, energy: f64) -> f64 {
        let blocks = &prices.tariff.blocks;
        if !class.counts || blocks.count == 1 {
            return energy * class.price(0);
        }
        let scale = self.scale(prices, self.day);
        let (mut left, mut cost) = (energy, 0.0);
        for block in 0..blocks.count {
            let is_last = block + 1 == blocks.count;
            let room = (blocks.up_to[block] * scale - self.block_energy).max(0.0);
            let part = if is_last { left } else { left.min(room) };
            self.block_energy += part;
            cost += part * class.price(block);
            left -= part;
        }
        cost
    }

    /// Measures the mean power of the current quarter-hour. Its energy so far is a lower bound that only grows, so the
    /// peak is charged as it builds up.
    fn measure(&mut self, prices: &Prices, quarter: usize, energy: f64) {
        if self.quarter != quarter {
            (self.quarter, self.quarter_energy) = (quarter, 0.0);
        }
        self.quarter_energy += energy;
        let power = self.quarter_energy * 4.0;
        let applying = prices.charges_at(quarter);
        for (index, charge) in prices.tariff.charges.iter().enumerate() {
            if applying & 1 << index != 0 {
                self.peaks[index] = self.peaks[index].max(power);
                if charge.ratchet.as_ref().is_some_and(|ratchet| {
                    ratchet.dates.contain(prices.calendar.day_of_common_year(self.day))
                }) {
                    self.ratchets[index] = self.ratchets[index].max(power);
                }
            }
        }
    }

    /// Begins a day, and a new month if it starts one.
    fn enter(&mut self, day: u32, prices: &Prices) {
        if day == self.day {
            return;
        }
        if is_reset(&prices.tariff.blocks, prices.calendar, self.day, day) {
            self.block_energy = 0.0;
        }
        let month = prices.calendar.month_of(day);
        if self.day == 0 || month != self.month {
            for index in 0..prices.tariff.charges.len() {
                let now = self.charge(prices, index);
                self.closed[index].cost += now.cost;
                self.closed[index].quantity = self.closed[index].quantity.max(now.quantity);
                self.shares[index] = self.share(prices, index, day);
            }
            self.peaks = [0.0; MAX_CHARGES];
            self.month = month;
        }
        self.day = day;
    }

    /// Returns the cost of all demand charges so far.
    fn demand(&self, prices: &Prices) -> f64 {
        let charges = 0..prices.tariff.charges.len();
        charges.map(|index| self.closed[index].cost + self.charge(prices, index).cost).sum()
    }

    /// Returns the billed kW of a charge in the current month and their cost.
    fn charge(&self, prices: &Prices, index: usize) -> Amount {
        let charge = &prices.tariff.charges[index];
        let least = self.least(charge, index);
        let subtracted = (0..MAX_CHARGES).filter(|other| charge.excess_over & 1 << other != 0);
        let subtracted = subtracted.map(|other| self.peaks[other]).fold(0.0, f64::max);
        let share = self.shares[index];
        let billed = (self.peaks[index].max(least) - subtracted - charge.above).max(0.0);
        let quantity = if share > 0.0 { billed } else { 0.0 };
        Amount { quantity, cost: quantity * charge.price * share }
    }

    /// Returns the kW of a charge that a ratchet bills in any case.
    fn least(&self, charge: &Charge, index: usize) -> f64 {
        charge.ratchet.as_ref().map_or(0.0, |ratchet| ratchet.share * self.ratchets[index])
    }

    /// Returns the days of a day's month that the episode covers and that are among a charge's dates, in months.
    fn share(&self, prices: &Prices, index: usize, day: u32) -> f64 {
        let charge = &prices.tariff.charges[index];
        let (covered, month) = (self.covered(prices.calendar, day), prices.calendar.month_of(day));
        let days =
            covered.filter(|day| charge.dates.contain(prices.calendar.day_of_common_year(*day))).count();
        days as f64 / f64::from(month_days(prices, month))
    }

    /// Returns the factor on the ends of blocks on a day.
    fn scale(&self, prices: &Prices, day: u32) -> f64 {
        let covered = self.covered(prices.calendar, day).count() as f64;
        match prices.tariff.blocks.per {
            Per::Day => 1.0,
            Per::DayOfMonth => covered,
            Per::Month => covered / f64::from(month_days(prices, prices.calendar.month_of(day))),
        }
    }

    /// Returns the days of a day's month that the episode covers. If an episode of a year begins and ends in the same
    /// month, its beginning and its end count separately.
    fn covered(&self, calendar: Calendar, day: u32) -> impl Iterator<Item = u32> {
        let month = calendar.month_of(day);
        let start = calendar.month_start(month);
        let (first, last) = match (self.first_day, self.last_day) {
            (first, last) if first <= last => (first, last),
            (first, _) if day >= first => (first, u32::MAX),
            (_, last) => (0, last),
        };
        let covers = move |day: &u32| (first..=last).contains(day);
        (start..start + calendar.month_days(month)).filter(covers)
    }
}

/// Returns the number of days that a tariff counts in a month, 0 to 11.
fn month_days(prices: &Prices, month: usize) -> u32 {
    prices.tariff.month_days.unwrap_or(prices.calendar.month_days(month))
}

/// Returns whether the kWh of blocks start over between two days.
fn is_reset(blocks: &Blocks, calendar: Calendar, before: u32, after: u32) -> bool {
    match blocks.per {
        Per::Day => before != after,
        Per::DayOfMonth | Per::Month => before == 0 || calendar.month_of(before) != calendar.month_of(after),
    }
}
