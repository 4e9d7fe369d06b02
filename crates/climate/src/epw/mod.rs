//! EPW weather files, read as the engine reads them.

pub(crate) mod column;
mod file;
mod header;
mod record;
mod row;
mod warmer;

pub use file::EpwFile;
pub(crate) use header::{Header, Line};
pub(crate) use record::mean;
pub use record::{Hour, Record};
