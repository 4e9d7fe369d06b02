//! An episode in the weather that forecasts predict.

use std::sync::Arc;

use b2b_base::scratch::temporary_folder;
use b2b_climate::EpwFile;
use b2b_env::{Environment, EpisodeConfig, Forecast, PREVIEW_HOURS, Preview, Spaces};
use b2b_workers::{Episode, EpisodeSetting};
use tempfile::TempDir;

use crate::{Error, Result};

/// Hours of a day.
const DAY: usize = 24;

/// An episode in the weather that forecasts predict at the midnight of each day, in a file of its own.
pub(super) struct Predicted {
    pub(super) episode: Episode,
    _folder: TempDir,
}

impl Predicted {
    /// Returns the episode in the weather of forecasts with an error, K, 24 hours ahead.
    ///
    /// # Errors
    /// [`Error::Io`]; the errors of [`Forecast::of`] and [`Episode`].
    pub(super) fn new(actual: &Episode, error: f64, seed: u64) -> Result<Self> {
        let text = weather(actual.spaces(), Preview { temperature_error: error, solar_error: 0.0, seed })?;
        let folder = temporary_folder("b2b-forecast-").map_err(b2b_energyplus::Error::from);
        let folder = folder.map_err(b2b_env::Error::from)?;
        let path = folder.path().join("predicted.epw");
        std::fs::write(&path, text).map_err(|source| Error::Io { path: path.clone(), source })?;
        let setting = actual.setting();
        let setting = EpisodeSetting {
            source: Arc::clone(&setting.source),
            episode: EpisodeConfig { weather: path, ..setting.episode.clone() },
        };
        Ok(Self { episode: actual.workers().episode(&setting)?, _folder: folder })
    }
}

/// Returns the text of an episode's weather with the outdoor temperatures that forecasts predict at the midnights of its
/// days.
fn weather(spaces: &Spaces, preview: Preview) -> Result<String> {
    const { assert!(PREVIEW_HOURS == DAY) }
    let EpisodeConfig { weather, period, .. } = &spaces.episode;
    let forecast = Forecast::of(spaces, preview)?;
    let mut errors = vec![0.0; DAY * period.calendar().days() as usize];
    for day in (0..period.days()).map(|after| period.day_of_year(after)) {
        errors[DAY * (day as usize - 1)..][..DAY].copy_from_slice(&forecast.errors_of_day(day));
    }
    let file = EpwFile::open(weather).map_err(b2b_env::Error::building)?;
    Ok(file.with_warmer_air(period.calendar(), &errors).map_err(b2b_env::Error::building)?)
}
