//! What the searches of parameters, schedules and rules share.

pub(crate) mod least_squares;
pub(crate) mod record_file;
