//! The weather forecast of a [preview](Preview).

use std::path::Path;
use std::sync::Arc;

use b2b_base::calendar::Calendar;
use b2b_base::random::standard_normal;
use b2b_climate::EpwFile;

use crate::preview::{PREVIEW_HOURS, Preview};
use crate::random::stream;
use crate::spaces::{EpisodeConfig, Spaces};
use crate::{Error, Result};

/// The first of the random streams of forecasts, one for each hour of the year.
const FIRST_STREAM: u64 = 1 << 41;

/// The weather forecast of an episode.
#[derive(Clone, Debug)]
pub struct Forecast {
    preview: Preview,
    /// Outdoor temperature at the end of every hour of the year, °C.
    temperatures: Arc<[f64]>,
    /// Mean global horizontal radiation of every hour of the year, W/m².
    solar: Arc<[f64]>,
}

impl Forecast {
    /// Returns the forecast of an episode's weather.
    ///
    /// # Errors
    /// [`Error::Building`] if the weather file cannot be read.
    pub fn of(spaces: &Spaces, preview: Preview) -> Result<Self> {
        let EpisodeConfig { weather, period, .. } = &spaces.episode;
        Self::new(preview, weather, period.calendar())
    }

    /// Returns the forecast of a weather file in a calendar.
    ///
    /// # Errors
    /// [`Error::Building`] if the file cannot be read.
    pub(crate) fn new(preview: Preview, weather: &Path, calendar: Calendar) -> Result<Self> {
        let file = EpwFile::open(weather).map_err(Error::building)?;
        let record = file.record().map_err(Error::building)?;
        Ok(Self {
            preview,
            temperatures: record.dry_bulbs_in(calendar).into(),
            solar: record.global_radiation_in(calendar).into(),
        })
    }

    /// Writes the outdoor temperature (°C) at the end of each of the next hours of the clock, and the mean solar
    /// radiation (W/m²) in each.
    pub fn write(&self, day_of_year: u32, hour: f64, temperatures: &mut [f64], solar: &mut [f64]) {
        let now = 24 * (day_of_year as usize - 1) + hour as usize;
        for ahead in 0..PREVIEW_HOURS {
            let at = (now + ahead) % self.temperatures.len();
            (temperatures[ahead], solar[ahead]) = (self.temperatures[at], self.solar[at]);
        }
        if self.preview.has_errors() {
            self.disturb(now, temperatures, solar);
        }
    }

    /// Returns the errors of the outdoor temperatures that are forecast at the midnight of a day, K.
    pub fn errors_of_day(&self, day_of_year: u32) -> [f64; PREVIEW_HOURS] {
        let [mut errors, mut solar] = [[0.0; PREVIEW_HOURS]; 2];
        self.disturb(24 * (day_of_year as usize - 1), &mut errors, &mut solar);
        errors
    }

    /// Adds the errors of the forecast of an hour of the year.
    fn disturb(&self, now: usize, temperatures: &mut [f64], solar: &mut [f64]) {
        let mut random = stream(self.preview.seed, FIRST_STREAM + now as u64);
        let step = 1.0 / (PREVIEW_HOURS as f64).sqrt();
        let mut errors = [0.0; 2];
        for ahead in 0..PREVIEW_HOURS {
            for (error, size) in
                errors.iter_mut().zip([self.preview.temperature_error, self.preview.solar_error])
            {
                *error += size * step * standard_normal(&mut random);
            }
            temperatures[ahead] += errors[0];
            solar[ahead] = (solar[ahead] * (1.0 + errors[1])).max(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOURS_OF_YEAR: usize = 8760;

    fn forecast(preview: Preview) -> Forecast {
        let temperatures: Vec<f64> = (0..HOURS_OF_YEAR).map(|hour| hour as f64 / 100.0).collect();
        Forecast { preview, temperatures: temperatures.into(), solar: vec![500.0; HOURS_OF_YEAR].into() }
    }

    fn of(preview: Preview, day: u32, hour: f64) -> [[f64; PREVIEW_HOURS]; 2] {
        let mut values = [[0.0; PREVIEW_HOURS]; 2];
        let [temperatures, solar] = &mut values;
        forecast(preview).write(day, hour, temperatures, solar);
        values
    }

    #[test]
    fn without_errors_the_forecast_is_the_weather() {
        let [temperatures, solar] = of(Preview::default(), 2, 3.9);
        assert_eq!((temperatures[0], temperatures[23], solar[5]), (0.27, 0.50, 500.0));
        let [wrapped, _] = of(Preview::default(), 365, 23.0);
        assert_eq!((wrapped[0], wrapped[1]), (87.59, 0.0), "the year begins anew");
    }

    #[test]
    fn errors_grow_with_time_ahead_and_follow_the_seed() {
        let preview = Preview { temperature_error: 2.0, solar_error: 0.3, seed: 1 };
        assert_eq!(of(preview, 10, 0.0), of(preview, 10, 0.5), "a forecast holds for an hour");
        assert_ne!(of(preview, 10, 0.0), of(Preview { seed: 2, ..preview }, 10, 0.0));
        let [[with, _], [without, _]] = [preview, Preview::default()].map(|preview| of(preview, 10, 0.0));
        for (ahead, error) in forecast(preview).errors_of_day(10).into_iter().enumerate() {
            assert!((with[ahead] - without[ahead] - error).abs() < 1e-9, "{ahead}: {error}");
        }
        let deviation = |ahead: usize| {
            let square = |hour: u32| {
                let (with, without) = (
                    of(preview, 1 + hour / 24, f64::from(hour % 24)),
                    of(Preview::default(), 1 + hour / 24, f64::from(hour % 24)),
                );
                (with[0][ahead] - without[0][ahead]).powi(2)
            };
            ((0..2000).map(square).sum::<f64>() / 2000.0).sqrt()
        };
        assert!((deviation(23) - 2.0).abs() < 0.15, "{}", deviation(23));
        assert!((deviation(5) - 1.0).abs() < 0.08, "{}", deviation(5));
    }
}
