//! The week of an office: people from 8:00 to 18:00 on the first five days, the band of occupied hours from 7:00 to
//! 19:00.

use super::super::points::{NextBand, Setpoints, ZoneInput};
use super::{DAY, STEP};

pub(super) const OCCUPIED: Setpoints = Setpoints { heating: 21.0, cooling: 24.0 };
pub(super) const UNOCCUPIED: Setpoints = Setpoints { heating: 15.6, cooling: 28.0 };
/// Hours of the band of occupied hours.
const BAND: [f64; 2] = [7.0, 19.0];
/// Hours with people.
const PEOPLE: [f64; 2] = [8.0, 18.0];
const WORKDAYS: usize = 5;

/// Returns the day and the hour at which a step begins.
pub(super) fn time(step: usize) -> (usize, f64) {
    (step / DAY, (step % DAY) as f64 * STEP)
}

/// Returns whether people are present.
pub(super) fn has_people(step: usize) -> bool {
    let (day, hour) = time(step);
    day % 7 < WORKDAYS && within(PEOPLE, hour)
}

/// Returns the band at a step.
pub(super) fn band(step: usize) -> Setpoints {
    let (day, hour) = time(step);
    if day % 7 < WORKDAYS && within(BAND, hour) { OCCUPIED } else { UNOCCUPIED }
}

/// Returns the points of a zone at a temperature, °C.
pub(super) fn points(step: usize, temperature: f64) -> ZoneInput {
    let now = band(step);
    let later = (step + 1..step + 4 * DAY).find(|&later| band(later) != now);
    let next = later.map(|later| {
        let Setpoints { heating, cooling } = band(later);
        NextBand { hours: (later - step) as f64 * STEP, heating, cooling }
    });
    let Setpoints { heating, cooling } = now;
    ZoneInput { temperature, heating, cooling, people: has_people(step), next }
}

/// Returns the outdoor temperature, °C, of a day with a mean and an amplitude; warmest at 15:00.
pub(super) fn outdoor(step: usize, mean: f64, amplitude: f64) -> f64 {
    let (_, hour) = time(step);
    mean + amplitude * ((hour - 15.0) / 24.0 * std::f64::consts::TAU).cos()
}

fn within(hours: [f64; 2], hour: f64) -> bool {
    (hours[0] - 1e-9..hours[1] - 1e-9).contains(&hour)
}
