//! Outdoor temperatures of the weather file and their scale.

use b2b_climate::EpwFile;
use b2b_env::Spaces;

use crate::{Error, Result};

/// Center and scale of outdoor temperatures, °C and K.
pub(super) const OUTDOOR: (f64, f64) = (10.0, 15.0);

/// Returns the outdoor temperatures at the end of each hour of the year, °C; none if the forecast has no hours.
///
/// # Errors
/// [`Error::Weather`] for an unreadable weather file.
pub(super) fn temperatures(hours: u32, spaces: &Spaces) -> Result<Vec<f64>> {
    if hours == 0 {
        return Ok(Vec::new());
    }
    let calendar = spaces.episode.period.calendar();
    let read = |path| Ok(EpwFile::open(path)?.record()?.dry_bulbs_in(calendar));
    read(&spaces.episode.weather).map_err(|error: b2b_climate::Error| Error::Weather(Box::new(error)))
}

/// Returns the temperature at an hour of the year, interpolated between the [`temperatures`] at the ends of hours.
pub(super) fn at_hour(temperatures: &[f64], hour: f64) -> f64 {
    let place = (hour - 1.0).rem_euclid(temperatures.len() as f64);
    let (index, share) = (place as usize % temperatures.len(), place.fract());
    temperatures[index] * (1.0 - share) + temperatures[(index + 1) % temperatures.len()] * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_temperature_of_the_weather_file_is_at_the_end_of_its_hour() {
        let temperatures: Vec<f64> = (1..=8760).map(f64::from).collect();
        assert_eq!([1.0, 1.5, 8760.0].map(|hour| at_hour(&temperatures, hour)), [1.0, 1.5, 8760.0]);
        assert_eq!([8761.0, 8760.5].map(|hour| at_hour(&temperatures, hour)), [1.0, 4380.5]);
    }
}
