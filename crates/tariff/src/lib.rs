//! Tariffs and emissions: energy prices by season, weekday, hour and block, demand charges on 15-minute peaks, events
//! announced the day before, and hourly emission profiles.
//!
//! - [`Tariff`] is a file: `Tariff::named("hq-m")` is a shipped one, [`Tariff::read`] a user's own.
//! - [`Prices`] lays it out in a [`Calendar`], with the [`Event`]s that [`Tariff::events`] chooses, and gives prices
//!   now and in the next 23 hours.
//! - [`Bill`] adds up an episode step by step: the costs of its steps sum up to the bill. A controller may use
//!   [`Bill::block`] and [`Bill::free_power`].
//! - [`Emissions`] gives kg of CO₂ equivalent per kWh by carrier and hour.
//!
//! ```
//! use b2b_tariff::{Bill, Calendar, Carrier, Moment, Prices, Tariff};
//!
//! let prices = Prices::new(Tariff::named("fpl-gsdt-1")?, Calendar::default(), &[], None)?;
//! let mut bill = Bill::new(184, 197);
//! let mut energy = [0.0; Carrier::ALL.len()];
//! energy[Carrier::Electricity as usize] = 0.5; // kWh
//! let cost = bill.step(&prices, Moment { day: 184, hour: 14.0 }, &energy, 1.0 / 12.0);
//! assert!(cost.energy > 0.0 && cost.demand > 0.0);
//! # Ok::<(), b2b_tariff::Error>(())
//! ```
//!
//! Times are on the simulation's clock: standard time, days of the year from 1. The windows of a tariff are on the
//! local clock, which daylight time advances by an hour where the tariff says so. Costs are in the tariff's own
//! currency. Fixed charges and taxes are left out; a controller does not change them. `docs/tariffs.md` describes the
//! files.

#![forbid(unsafe_code)]

mod bill;
mod calendar;
mod charge;
mod emissions;
mod energy;
mod error;
mod events;
mod file;
mod fuel;
mod prices;
mod shipped;
mod span;
mod tariff;

pub use b2b_base::calendar::Calendar;
pub use b2b_base::carrier::{Carrier, CarrierEnergy};
pub use bill::{Bill, Part, StepCost};
pub use calendar::Moment;
pub use emissions::{Emissions, Rate};
pub use error::{Error, Result};
pub use events::Event;
pub use file::{Customers, Source};
pub use fuel::FuelValues;
pub use prices::{PREVIEW, Prices};
pub use shipped::shipped_text;
pub use tariff::Tariff;
