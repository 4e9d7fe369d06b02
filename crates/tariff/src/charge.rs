//! Demand charges of a tariff.

use b2b_base::suggestion::{did_you_mean, nearest};
use toml::Spanned;

use crate::calendar::DAYS;
use crate::error::Fault;
use crate::file::{DemandFile, MAX_CHARGES, Ratchet};
use crate::span::{Dates, Days, Hours};

/// A charge on the largest 15-minute mean of a month.
#[derive(Clone, Debug)]
pub(crate) struct Charge {
    /// Name on a bill.
    pub(crate) name: String,
    /// Per kW and month.
    pub(crate) price: f64,
    /// kW that are free.
    pub(crate) above: f64,
    /// Charges whose peak is subtracted: a bit each.
    pub(crate) excess_over: u8,
    pub(crate) ratchet: Option<Ratchet>,
    pub(crate) dates: Dates,
    days: Days,
    hours: Option<Vec<Hours>>,
}

impl Charge {
    /// Returns whether a quarter-hour is among its times.
    pub(crate) fn applies(&self, day: u32, weekend: bool, quarter: u32) -> bool {
        let hours = |hours: &Vec<Hours>| hours.iter().any(|hours| (hours.from..hours.to).contains(&quarter));
        self.dates.contain(day) && self.days.contain(weekend) && self.hours.as_ref().is_none_or(hours)
    }
}

/// Returns the demand charges of a file.
///
/// # Errors
/// A fault of a charge.
pub(crate) fn charges(entries: &[Spanned<DemandFile>]) -> Result<Vec<Charge>, Fault> {
    if let Some(extra) = entries.get(MAX_CHARGES) {
        return Err(Fault::at(extra.span().start, format!("more than {MAX_CHARGES} demand charges")));
    }
    entries.iter().map(|entry| charge(entry, entries)).collect()
}

fn charge(entry: &Spanned<DemandFile>, all: &[Spanned<DemandFile>]) -> Result<Charge, Fault> {
    let place = entry.span().start;
    let entry = entry.get_ref();
    let fault = |why: String| Fault::at(place, format!("the demand charge `{}` {why}", entry.name));
    for (name, value) in [("price", entry.price), ("above", entry.above)] {
        if !value.is_finite() || value < 0.0 {
            return Err(fault(format!("has `{name}` {value}; expected a number of at least 0")));
        }
    }
    if let Some(share) = entry.ratchet.as_ref().map(|ratchet| ratchet.share)
        && !(0.0..=1.0).contains(&share)
    {
        return Err(fault(format!("has the ratchet share {share}; expected 0 to 1, such as 0.65")));
    }
    if entry.hours.as_ref().is_some_and(Vec::is_empty) {
        return Err(fault("has no `hours`; expected times such as \"16-20\", or leave `hours` out".into()));
    }
    let never =
        |ratchet: &Ratchet| !(1..=DAYS).any(|day| entry.dates.contain(day) && ratchet.dates.contain(day));
    if entry.ratchet.as_ref().is_some_and(never) {
        return Err(fault(
            "has a ratchet without effect: none of its dates is among the charge's `dates`".into(),
        ));
    }
    Ok(Charge {
        name: entry.name.clone(),
        price: entry.price,
        above: entry.above,
        excess_over: excess_over(entry, all).map_err(fault)?,
        ratchet: entry.ratchet.clone(),
        dates: entry.dates.clone(),
        days: entry.days,
        hours: entry.hours.clone(),
    })
}

/// Returns the charges whose peaks are subtracted from an entry's, a bit each.
fn excess_over(entry: &DemandFile, all: &[Spanned<DemandFile>]) -> Result<u8, String> {
    let Some(wanted) = &entry.excess_over else { return Ok(0) };
    let others = || all.iter().map(|other| other.get_ref().name.as_str());
    let bits = others().enumerate().filter(|(_, name)| *name == wanted && *name != entry.name);
    let bits = bits.fold(0, |bits, (bit, _)| bits | 1 << bit);
    if bits == 0 {
        let near = nearest(wanted, others().filter(|name| *name != entry.name));
        let near = did_you_mean(&near);
        return Err(format!(
            "has `excess_over` {wanted:?}{near}; expected the name of another demand charge"
        ));
    }
    Ok(bits)
}
