//! An episode in the weather that forecasts predict.

use std::sync::Arc;

use b2b_climate::EpwFile;
use b2b_env::{Environment, EpisodeConfig, Forecast, PREVIEW_HOURS, Preview, Spaces};
use b2b_workers::{Episode, EpisodeSetting};
use tempfile::NamedTempFile;

use crate::{Error, Result};

/// An episode in the weather that forecasts predict at the midnight of each day, in a file of its own.
pub(super) struct Predicted {
    pub(super) episode: Episode,
    _weather: NamedTempFile,
}

impl Predicted {
    /// Returns the episode in the weather of forecasts with an error, K, 24 hours ahead.
    ///
    /// # Errors
    /// [`Error::Io`]; the errors of [`Forecast::of`] and [`Episode`].
    pub(super) fn new(actual: &Episode, error: f64, seed: u64) -> Result<Self> {
        let text = weather(actual.spaces(), Preview { temperature_error: error, solar_error: 0.0, seed })?;
        let at = |source| Error::Io { path: std::env::temp_dir(), source };
        let file = tempfile::Builder::new().suffix(".epw").tempfile().map_err(at)?;
        std::fs::write(file.path(), text).map_err(at)?;
        let setting = actual.setting();
        let episode = EpisodeConfig { weather: file.path().to_owned(), ..setting.episode.clone() };
        let setting = EpisodeSetting { source: Arc::clone(&setting.source), episode };
        Ok(Self { episode: actual.workers().episode(&setting)?, _weather: file })
    }
}

/// Returns the text of an episode's weather with the outdoor temperatures that forecasts predict at midnights.
fn weather(spaces: &Spaces, preview: Preview) -> Result<String> {
    let EpisodeConfig { weather, period, .. } = &spaces.episode;
    let (predicted, actual) = (Forecast::of(spaces, preview)?, Forecast::of(spaces, Preview::default())?);
    let temperatures = |forecast: &Forecast, day: u32| {
        let [mut temperatures, mut solar] = [[0.0; PREVIEW_HOURS]; 2];
        forecast.write(day, 0.0, &mut temperatures, &mut solar);
        temperatures
    };
    let errors = |day: u32| {
        let (predicted, actual) = (temperatures(&predicted, day), temperatures(&actual, day));
        predicted.into_iter().zip(actual).map(|(predicted, actual)| predicted - actual)
    };
    let shifts: Vec<f64> = (1..=period.calendar().days()).flat_map(errors).collect();
    let file = EpwFile::open(weather).map_err(b2b_env::Error::building)?;
    Ok(file.with_warmer_air(period.calendar(), &shifts).map_err(b2b_env::Error::building)?)
}
