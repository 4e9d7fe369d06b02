//! Shared by the tests of bills: prices of 2017, and an episode with a given load.

use b2b_tariff::{Bill, Calendar, Carrier, CarrierEnergy, Event, Moment, Prices, StepCost, Tariff};

/// 2017: 1 January is a Sunday.
pub const YEAR: Calendar = Calendar::new(6, false);
/// 5 minutes in hours.
pub const STEP: f64 = 1.0 / 12.0;

/// Returns the day of the year of a month and a day.
pub fn day(month: usize, day: u32) -> u32 {
    let lengths = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    lengths[..month - 1].iter().sum::<u32>() + day
}

/// Returns the prices of a shipped tariff in 2017.
pub fn prices(name: &str, events: &[Event], outdoor: Option<&[f64]>) -> Prices {
    Prices::new(Tariff::named(name).unwrap(), YEAR, events, outdoor).unwrap()
}

/// Returns the energy of electricity alone.
pub fn electricity(energy: f64) -> CarrierEnergy {
    let mut by_fuel = [0.0; Carrier::ALL.len()];
    by_fuel[Carrier::Electricity as usize] = energy;
    by_fuel
}

/// Runs an episode of 5-minute steps whose electric power in kW is a function of the moment.
pub fn run(prices: &Prices, first: u32, last: u32, power: impl Fn(Moment) -> f64) -> (Bill, Vec<StepCost>) {
    let mut bill = Bill::new(first, last);
    let mut costs = Vec::new();
    for day in first..=last {
        for step in 0..288 {
            let at = Moment { day, hour: f64::from(step) * STEP };
            costs.push(bill.step(prices, at, &electricity(power(at) * STEP), STEP));
        }
    }
    (bill, costs)
}

/// Returns the cost of a part of a bill.
pub fn part(bill: &Bill, prices: &Prices, name: &str) -> f64 {
    let parts = bill.parts(prices);
    parts.iter().find(|part| part.name == name).unwrap_or_else(|| panic!("no `{name}` in {parts:?}")).cost
}

/// Asserts that two costs are the same to a millionth.
#[track_caller]
pub fn assert_cost(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{found}, expected {expected}");
}
