//! The ducted unit: air loop, coils, sizes and controls.

pub(crate) mod air_loop;
pub(crate) mod capacities;
pub(crate) mod coils;
pub(crate) mod loads;
pub(crate) mod schedules;
pub(crate) mod thermostat;
