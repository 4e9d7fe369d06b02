//! Objects of a model that systems consist of, and edits of them that kinds of systems share.

pub mod air_loop_graph;
pub(super) mod availability;
pub(crate) mod distribution;
pub(crate) mod energy_management;
pub(crate) mod given_thermostat;
pub mod references;
pub(super) mod schedules;
pub(super) mod setpoint_managers;
pub mod thermostat;
pub(super) mod zone_controls;
pub mod zone_equipment;
