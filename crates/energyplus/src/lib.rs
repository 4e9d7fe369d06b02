//! TODO

pub mod install;
