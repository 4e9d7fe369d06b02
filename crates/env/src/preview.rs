//! The preview: what a building management system knows about the hours ahead, as part of the observation.
//!
//! For every controlled zone, it has the next scheduled change of its setpoints; for the building, the electricity
//! price, the outdoor temperature and the solar radiation of the next 24 hours, one value per hour.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::limits::within;

/// Hours ahead of prices and weather.
pub const PREVIEW_HOURS: usize = b2b_tariff::PREVIEW;

/// The preview of a task. The errors of the weather forecast grow with the square root of the time ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Preview {
    /// Standard deviation of the error of the outdoor temperature 24 hours ahead, K.
    pub temperature_error: f64,
    /// Standard deviation of the error of the solar radiation 24 hours ahead, as a share of the radiation.
    pub solar_error: f64,
    /// Random seed of the errors.
    pub seed: u64,
}

impl Preview {
    pub(crate) fn has_errors(&self) -> bool {
        self.temperature_error > 0.0 || self.solar_error > 0.0
    }

    pub(crate) fn check(&self) -> Result<()> {
        within("temperature_error", self.temperature_error, 0.0, 20.0)?;
        within("solar_error", self.solar_error, 0.0, 2.0)
    }
}
