//! Runs of EnergyPlus outside this process.

use std::fmt;
use std::path::Path;

use crate::{Messages, Result};

/// Runs EnergyPlus in other processes, for models that may crash it: see
/// [`Library::hosted_by`](crate::Library::hosted_by).
///
/// A crash is then an error, [`Error::Process`](crate::Error::Process), and not the end of this process.
pub trait Host: fmt::Debug + Send + Sync {
    /// Converts an IDF file, like [`Library::convert_idf`](crate::Library::convert_idf).
    ///
    /// # Errors
    /// As there; [`Error::Process`](crate::Error::Process); [`Error::Interrupted`](crate::Error::Interrupted).
    fn convert_idf(&self, idf: &Path) -> Result<String>;

    /// Runs a model (epJSON or IDF) over a weather file to its end, like [`Run::to_end`](crate::Run::to_end).
    ///
    /// # Errors
    /// As there; [`Error::Process`](crate::Error::Process); [`Error::Interrupted`](crate::Error::Interrupted).
    fn run_to_end(&self, model: &Path, weather: &Path, output: &Path) -> Result<Messages>;
}
