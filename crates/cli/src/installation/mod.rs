//! The installation: its repair and its state.

pub(crate) mod derived;
pub(crate) mod doctor;
pub(crate) mod setup;
