//! Regressors of the cost and discomfort of hours without shifts.

use super::drivers::Drivers;
use super::hour::Hour;

/// Hours of the day in which buildings are prepared for people.
const EARLY: std::ops::RangeInclusive<usize> = 5..=9;
/// Hours of solar radiation that walls and floors keep.
const KEPT: usize = 5;
/// Solar radiation that counts as 1, W/m².
const RADIATION: f64 = 500.0;
/// Smallest sum of the absolute values of a regressor, relative to its largest, with which it is used.
const LEAST_SUM: f64 = 3.0;
/// Distance to a setpoint within which a zone counts as heated or cooled, K.
const NEAR: f64 = 1.0;
/// Distance of the outdoor temperature below the zones' at which they begin to gain heat, K.
const GAIN: f64 = 8.0;
/// Units of heat losses and gains, K.
const UNITS: [f64; 2] = [20.0, 10.0];

/// Returns what is known before an hour: its place in the day, the weather, people, and how far zones are from their
/// setpoints.
pub(super) fn expected_inputs(hours: &[Hour], drivers: &[Drivers]) -> Vec<Vec<f64>> {
    let is_narrow: Vec<bool> = drivers.iter().map(|own| own.narrow() > 0.5).collect();
    let day = |row: usize| row / 24 * 24..hours.len().min(row / 24 * 24 + 24);
    let works = |row: usize| is_narrow[day(row)].contains(&true);
    let row = |row: usize| {
        let (hour, works) = (&hours[row], works(row));
        let [narrow, early] =
            [is_narrow[row], works && EARLY.contains(&hour.of_day)].map(|is| f64::from(u8::from(is)));
        let mut inputs = vec![narrow, drivers[row].narrow(), narrow * hour.occupancy];
        let weather = weather(hours, row);
        for factor in [1.0, narrow, early] {
            inputs.extend(weather.map(|value| factor * value));
        }
        inputs.extend(Need::of(hour, hours.get(row + 1).unwrap_or(hour)).recovery);
        let mut clock = [0.0; 48];
        clock[hour.of_day + 24 * usize::from(works)] = 1.0;
        inputs.extend(clock);
        inputs
    };
    (0..hours.len()).map(row).collect()
}

/// Returns [`expected_inputs`] and what is known afterward: how near zones were to their setpoints, and the heat that
/// units delivered.
pub(super) fn inputs(hours: &[Hour], drivers: &[Drivers]) -> Vec<Vec<f64>> {
    let mut all = expected_inputs(hours, drivers);
    let heat = scaled(hours);
    for (row, inputs) in all.iter_mut().enumerate() {
        let hour = &hours[row];
        let Need { near, weather, .. } = Need::of(hour, hours.get(row + 1).unwrap_or(hour));
        let narrow = f64::from(u8::from(drivers[row].narrow() > 0.5));
        for factor in [1.0, narrow] {
            inputs.extend(near.map(|near| factor * near));
            inputs.extend(weather.map(|weather| factor * weather));
            inputs.extend([0, 1].map(|side: usize| factor * near[side] * weather[side]));
        }
        inputs.extend(heat.iter().map(|form| form[row]));
    }
    all
}

/// Returns cold and warm of an hour, their squares, their means over a day, and solar radiation now and kept.
fn weather(hours: &[Hour], row: usize) -> [f64; 8] {
    let mean = |count: usize, value: fn(&Hour) -> f64| {
        let past = &hours[(row + 1).saturating_sub(count)..=row];
        past.iter().map(value).sum::<f64>() / past.len() as f64
    };
    let [cold, warm] = Drivers::cold_and_warm(hours[row].outdoor);
    let [cold_day, warm_day] = Drivers::cold_and_warm(mean(24, |hour| hour.outdoor));
    let [sun, kept] = [1, KEPT].map(|count| mean(count, |hour| hour.radiation) / RADIATION);
    [cold, warm, cold * cold, warm * warm, cold_day, warm_day, sun, kept]
}

/// Needs of the zones in an hour, as means.
struct Need {
    /// Distance below the heating and above the cooling setpoint, of this hour and of the next, K.
    recovery: [f64; 4],
    /// Share of the zones near their heating and their cooling setpoint.
    near: [f64; 2],
    /// Losses and gains by the outdoor temperature.
    weather: [f64; 2],
}

impl Need {
    fn of(hour: &Hour, next: &Hour) -> Self {
        let mut own = Self { recovery: [0.0; 4], near: [0.0; 2], weather: [0.0; 2] };
        let share = 1.0 / hour.zones.len() as f64;
        let mut temperature = 0.0;
        for ([air, heating, cooling], [_, next_heating, next_cooling]) in hour.zones.iter().zip(&next.zones) {
            let recovery = [heating - air, air - cooling, next_heating - air, air - next_cooling];
            own.recovery.iter_mut().zip(recovery).for_each(|(sum, own)| *sum += share * own.max(0.0));
            let near = [air - heating, cooling - air].map(|distance| (1.0 - distance / NEAR).clamp(0.0, 1.0));
            own.near.iter_mut().zip(near).for_each(|(sum, own)| *sum += share * own);
            temperature += share * air;
        }
        let differences = [temperature - hour.outdoor, hour.outdoor - temperature + GAIN];
        own.weather = [0, 1].map(|side: usize| differences[side].max(0.0) / UNITS[side]);
        own
    }
}

/// Returns the forms of heat that units delivered, each relative to its largest value, without those that hardly occur.
fn scaled(hours: &[Hour]) -> Vec<Vec<f64>> {
    let forms = hours.first().map_or(0, |hour| hour.delivered.len());
    let form = |index: usize| {
        let values = hours.iter().map(|hour| hour.delivered[index]);
        let largest = values.clone().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let scaled: Vec<f64> = values.map(|value| value / largest).collect();
        (largest > 0.0 && scaled.iter().map(|value| value.abs()).sum::<f64>() > LEAST_SUM).then_some(scaled)
    };
    (0..forms).filter_map(form).collect()
}
