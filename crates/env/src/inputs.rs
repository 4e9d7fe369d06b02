//! The inputs of an episode, by their digests.

use b2b_climate::EpwFile;
use serde::{Deserialize, Serialize};

use crate::{Error, Result, Spaces};

/// Digests of the model and the weather of an episode: equal digests mean equal inputs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Inputs {
    /// SHA-256 of the model, sized and made controllable.
    pub model_sha256: String,
    /// SHA-256 of the weather file.
    pub weather_sha256: String,
}

impl Inputs {
    /// Computes the digests of an episode's inputs.
    ///
    /// # Errors
    /// [`Error::Building`] if the weather file cannot be read.
    pub fn of(spaces: &Spaces) -> Result<Self> {
        let weather = &spaces.episode.weather;
        Ok(Self {
            model_sha256: spaces.building.model_sha256.clone(),
            weather_sha256: EpwFile::open(weather).map_err(Error::building)?.sha256().to_owned(),
        })
    }
}
