//! The terminal: text, progress, signals and exit codes.

pub(crate) mod exit_code;
pub(crate) mod front_page;
pub(crate) mod interrupt;
pub(crate) mod progress;
pub(crate) mod stdout;
pub(crate) mod suggestion;
pub(crate) mod table;
pub(crate) mod wrap;
