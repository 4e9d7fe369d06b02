//! HVAC systems under control: their actuators, with bounds and the engine variables that show the effect.
//!
//! A [`System`] has actuators and zones. Each kind of system is a file or a folder ([`unitary`], [`air_loop`],
//! [`heating_only`], `room_unit`, [`setpoints`]) that implements [`System`] and [`FromModel`], and an entry of
//! [`KINDS`]. All other code knows systems by these traits.

pub(crate) mod actuator;
pub mod air_loop;
mod candidate;
mod capacity;
mod discovery;
pub mod heating_only;
mod kind;
mod layout;
mod objects;
mod room_unit;
mod sequence;
pub mod setpoints;
mod system;
pub mod unitary;
mod ventilation;

pub use actuator::{Actuator, EngineVariable, Quantity};
pub use air_loop::{AirLoop, Terminal};
pub use candidate::Candidate;
pub use capacity::{Equipment, SystemEquipment};
pub use discovery::{Discovery, Uncontrolled, Unsupported};
pub(crate) use discovery::{discover, discover_setpoints, has_own_controls};
pub use heating_only::HeatingOnly;
pub use kind::Kind;
pub use layout::{ServedZone, SystemLayout};
pub use objects::{air_loop_graph, references, thermostat, zone_equipment};
use objects::{availability, schedules, setpoint_managers, zone_controls};
pub(crate) use objects::{distribution, energy_management, given_thermostat};
pub use room_unit::RoomUnit;
pub use sequence::Sequence;
pub use setpoints::{SetpointZone, separate};
pub(crate) use setpoints::{Switch, absent, switches_of_all};
pub use system::{FromModel, KindName, Object, SharedFlow, System, ZoneState};
pub use unitary::{Follower, HeatPump, Packaged, Unitary};
pub use ventilation::{MinimumDamper, Ventilation};

use std::collections::BTreeMap;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::Value;

/// Every kind of system, in the order in which they claim a part of a model.
pub static KINDS: [Kind; 5] = [
    Kind::of::<Unitary>(),
    Kind::of::<AirLoop>(),
    Kind::of::<HeatingOnly>(),
    Kind::of::<RoomUnit>(),
    Kind::of::<SetpointZone>(),
];

impl Kind {
    /// Returns the kind with an identifier, among [`KINDS`].
    pub fn find(id: &str) -> Option<Self> {
        KINDS.into_iter().find(|kind| kind.id() == id)
    }
}

impl<'de> Deserialize<'de> for Box<dyn System> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let tagged = BTreeMap::<String, Value>::deserialize(deserializer)?;
        let (id, fields) =
            tagged.into_iter().next().ok_or_else(|| D::Error::custom("a system without a kind"))?;
        let kind =
            Kind::find(&id).ok_or_else(|| D::Error::custom(format!("unknown kind of system `{id}`")))?;
        kind.read(fields).map_err(D::Error::custom)
    }
}
