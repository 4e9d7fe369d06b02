//! HVAC systems under control: their actuators, with bounds and the engine variables that show the effect.

mod actuator;
pub mod air_loop;
pub mod air_loop_graph;
mod availability;
mod controllable;
mod discovery;
pub(crate) mod distribution;
pub(crate) mod energy_management;
pub mod heating_only;
mod layout;
pub mod references;
mod schedules;
mod setpoint_managers;
mod system;
pub mod thermostat;
pub mod unitary;
mod ventilation;
pub mod zone_equipment;

pub use actuator::{Actuator, EngineVariable, Quantity};
pub use controllable::make_controllable;
pub use discovery::{Discovery, Uncontrolled};
pub(crate) use discovery::{discover, has_own_controls};
pub use layout::{ServedZone, SystemLayout};
pub use system::{AirLoop, HeatingOnly, System, Terminal, Unitary};
pub use ventilation::{MinimumDamper, Ventilation};
