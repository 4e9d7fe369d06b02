//! Hourly values of an episode.

use b2b_env::Spaces;
use serde::{Deserialize, Serialize};

use crate::evaluation::recording::{ControlledZone, Recording};

/// Hourly values of an episode in hundredths: a year fits in a small file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hours {
    /// Year, month and day of the first hour, in a year with the same days of the week; `None` in files without it.
    pub first_day: Option<[u32; 3]>,
    /// Temperature of the coldest controlled zone, °C/100.
    pub coldest: Vec<i32>,
    /// Mean temperature of the controlled zones, °C/100.
    pub mean: Vec<i32>,
    /// Temperature of the warmest controlled zone, °C/100.
    pub warmest: Vec<i32>,
    /// Mean target temperature, or mean heating setpoint of the bands, °C/100.
    pub target: Vec<i32>,
    /// Mean cooling setpoint of the bands of zones with cooling, °C/100; empty in a task with targets.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cooling: Vec<i32>,
    /// Outdoor air temperature, °C/100.
    pub outdoor: Vec<i32>,
    /// HVAC power, electricity and gas, W/m²/100.
    pub power: Vec<i32>,
}

impl Hours {
    /// Returns the hourly values of a recording.
    pub(in crate::evaluation) fn of(
        recording: &Recording,
        zones: &[ControlledZone],
        spaces: &Spaces,
    ) -> Self {
        let per_hour = spaces.episode.steps_per_hour as usize;
        let (outdoor, electricity, gas) = (
            spaces.observation.outdoor_temperature(),
            spaces.observation.electricity(),
            spaces.observation.gas(),
        );
        let all: Vec<_> = recording.steps().collect();
        let mut hours = Self { first_day: Some(spaces.episode.period.first_day()), ..Self::default() };
        for hour in all.chunks(per_hour) {
            let temperatures = || hour.iter().flat_map(|(_, end)| zones.iter().map(|zone| end[zone.slot]));
            let setpoints =
                || hour.iter().flat_map(|(before, _)| zones.iter().map(|zone| zone.setpoints(before)));
            hours.coldest.push(hundredths(temperatures().fold(f64::INFINITY, f64::min)));
            hours.warmest.push(hundredths(temperatures().fold(f64::NEG_INFINITY, f64::max)));
            hours.mean.push(hundredths(mean(temperatures())));
            hours.target.push(hundredths(mean(setpoints().map(|pair| pair.heating))));
            if spaces.episode.task.is_operation() {
                let cooling = setpoints().map(|pair| pair.cooling).filter(|setpoint| setpoint.is_finite());
                hours.cooling.push(hundredths(mean(cooling)));
            }
            hours.outdoor.push(hundredths(mean(hour.iter().map(|(_, end)| end[outdoor]))));
            // Wh/m² per step, times steps per hour.
            let power = mean(hour.iter().map(|(_, end)| end[electricity] + end[gas])) * per_hour as f64;
            hours.power.push(hundredths(power));
        }
        hours
    }
}

fn hundredths(value: f64) -> i32 {
    (value * 100.0).round() as i32
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value, count + 1));
    sum / count.max(1) as f64
}
