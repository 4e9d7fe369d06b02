//! The Python interpreter and this process: the command, exceptions, signals and folders.

pub(crate) mod arrays;
pub(crate) mod command;
pub(crate) mod error;
pub(crate) mod process;
pub(crate) mod signals;
pub(crate) mod temporary;
