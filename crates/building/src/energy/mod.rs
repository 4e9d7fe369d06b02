//! Energy of a building: its meters, and the engine's output files.

pub(crate) mod hvac_energy;
pub(crate) mod monthly_energy;
pub(crate) mod output_database;
pub(crate) mod outputs;
