//! Shared parts of the searches for parameters, schedules and rules.

pub(crate) mod least_squares;
pub(crate) mod record_file;

/// Discomfort beyond the guideline's that counts as none in a search, K·h per zone and day: half of what a score at
/// comfort leaves free.
pub(crate) const SAME_DISCOMFORT: f64 = 0.05;
