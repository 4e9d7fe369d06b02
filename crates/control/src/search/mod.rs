//! Shared parts of the searches for parameters, schedules and rules.

pub(crate) mod least_squares;
pub(crate) mod record_file;
