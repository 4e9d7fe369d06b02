//! Closed loops with small models of rooms, units and air handlers.

mod air_loop;
mod day;
pub(super) mod room;
mod single_zone;

/// Length of a step, h.
const STEP: f64 = 1.0 / 12.0;
/// Steps of a day.
const DAY: usize = 288;
