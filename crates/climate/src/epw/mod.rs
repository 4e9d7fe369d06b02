//! EPW weather files, read as the engine reads them.

mod file;
mod header;
mod record;
mod row;

pub use file::EpwFile;
pub(crate) use header::{Header, Line};
pub(crate) use record::mean;
pub use record::{Hour, Record};
