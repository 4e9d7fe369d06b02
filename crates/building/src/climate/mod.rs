//! Climate: the places whose weather is known, and their files.

pub mod weather;

pub use weather::{PLACES, Place};
