//! The TOML form of a tariff.

use serde::Deserialize;
use toml::Spanned;

use crate::calendar::{Date, Holiday};
use crate::fuel::Fuels;
use crate::span::{Dates, Days, Hours};

/// Maximum number of energy blocks.
pub(crate) const MAX_BLOCKS: usize = 4;
/// Maximum number of energy price names, including the names used for events and cold.
pub(crate) const MAX_NAMES: usize = 16;
/// Maximum number of demand charges.
pub(crate) const MAX_CHARGES: usize = 8;

/// The customers of a tariff.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Customers {
    /// Homes.
    Homes,
    /// Businesses.
    Businesses,
    /// Any customer: made for comparisons, not a utility's own.
    Any,
}

/// Where the figures of a file come from.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// The document or record.
    pub document: String,
    /// Date from which the figures are in force, or date of the document.
    pub date: String,
    /// Address.
    pub url: Option<String>,
    /// What was left out or assumed.
    pub note: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TariffFile {
    pub(crate) title: String,
    pub(crate) place: String,
    pub(crate) customers: Customers,
    pub(crate) currency: String,
    pub(crate) source: Source,
    pub(crate) electricity: Spanned<ElectricityFile>,
    pub(crate) fuels: Option<Spanned<Fuels>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ElectricityFile {
    pub(crate) daylight_time: bool,
    #[serde(default)]
    pub(crate) holidays: Vec<Holiday>,
    pub(crate) month_days: Option<u32>,
    pub(crate) blocks: Option<Spanned<BlocksFile>>,
    pub(crate) energy: Vec<Spanned<EnergyFile>>,
    #[serde(default)]
    pub(crate) demand: Vec<Spanned<DemandFile>>,
    pub(crate) events: Option<Spanned<EventsFile>>,
    pub(crate) cold: Option<Spanned<ColdFile>>,
}

/// Blocks of energy with their own prices.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BlocksFile {
    pub(crate) per: Per,
    pub(crate) up_to: Vec<f64>,
}

/// Time over which the kWh of a block are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Per {
    /// A number of kWh per day.
    Day,
    /// A number of kWh per day of the month, counted over the month.
    DayOfMonth,
    /// A number of kWh per month.
    Month,
}

/// An energy price of some dates, days and hours.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EnergyFile {
    pub(crate) name: String,
    #[serde(default = "Dates::all")]
    pub(crate) dates: Dates,
    #[serde(default)]
    pub(crate) days: Days,
    pub(crate) hours: Option<Vec<Hours>>,
    pub(crate) price: Option<Price>,
    pub(crate) hourly: Option<Vec<f64>>,
}

/// One price, or one for each block.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected `price` to be a number, or a list of numbers, one for each block")]
pub(crate) enum Price {
    One(f64),
    Blocks(Vec<f64>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DemandFile {
    pub(crate) name: String,
    #[serde(default = "Dates::all")]
    pub(crate) dates: Dates,
    #[serde(default)]
    pub(crate) days: Days,
    pub(crate) hours: Option<Vec<Hours>>,
    pub(crate) price: f64,
    #[serde(default)]
    pub(crate) above: f64,
    pub(crate) excess_over: Option<String>,
    pub(crate) ratchet: Option<Ratchet>,
}

/// The minimum billed demand, as a share of an earlier peak.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ratchet {
    pub(crate) share: f64,
    pub(crate) dates: Dates,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EventsFile {
    pub(crate) price: f64,
    pub(crate) dates: Dates,
    #[serde(default)]
    pub(crate) days: Days,
    pub(crate) hours: Vec<Hours>,
    pub(crate) most_per_day: u32,
    pub(crate) most_hours: f64,
    pub(crate) notice: Option<f64>,
    #[serde(default)]
    pub(crate) never: Vec<Date>,
}

/// The price below an outdoor temperature.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ColdFile {
    pub(crate) below: f64,
    pub(crate) price: f64,
}
