//! Units in the room that they serve, controlled by air flow and supply air temperature: packaged terminal air
//! conditioners and heat pumps, four-pipe fan coils, unitary systems without ducts.
//!
//! The engine controls such a unit by the load of its zone and by nothing else. It becomes the only unit of an air loop
//! of its own, with the same fan, coils and outdoor air ([`ducts`]); from there on it is a [`Unitary`] system.

mod ducts;
mod zone_nodes;

use serde::{Deserialize, Serialize};

use super::actuator::Actuator;
use super::candidate::Candidate;
use super::capacity::{Capacity, SystemEquipment};
use super::references::{Reference, is_one_of};
use super::sequence::Sequence;
use super::system::{FromModel, KindName, System, ZoneState};
use super::unitary::{self, Unitary};
use super::ventilation::Ventilation;
use crate::morphology::universe::NodeType;
use crate::shape::Shape;
use crate::zone;
use crate::{Model, Result};

/// The classes of units in a room.
const UNITS: [&str; 4] = [
    "ZoneHVAC:PackagedTerminalAirConditioner",
    "ZoneHVAC:PackagedTerminalHeatPump",
    "ZoneHVAC:FourPipeFanCoil",
    "AirLoopHVAC:UnitarySystem",
];

/// Design flow, in air changes of the room per hour, above which the room responds within a minute. One command per
/// step cannot hold it; the engine's own control can.
const MOST_AIR_CHANGES: f64 = 60.0;

/// A unit in the room that it serves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoomUnit {
    /// The unit in the model.
    pub object: Reference,
    /// The unit on its air loop.
    pub unit: Unitary,
}

/// Returns whether equipment of a zone is a unit in its room.
pub(super) fn is_unit(class: &str) -> bool {
    is_one_of(class, &UNITS)
}

impl System for RoomUnit {
    fn name(&self) -> &str {
        self.unit.name()
    }

    fn zones(&self) -> Vec<&str> {
        self.unit.zones()
    }

    fn actuators(&self) -> Vec<&Actuator> {
        self.unit.actuators()
    }

    fn node_type(&self, zone: usize) -> NodeType {
        self.unit.node_type(zone)
    }

    fn ventilation(&self) -> Option<&Ventilation> {
        self.unit.ventilation()
    }

    fn outdoor_air_limits(&self) -> Vec<(usize, f64)> {
        self.unit.outdoor_air_limits()
    }

    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]) {
        self.unit.warm_up(zone, action);
    }

    fn sequence(&self) -> Sequence<'_> {
        self.unit.sequence()
    }

    fn equipment(&self, model: &Model) -> Result<SystemEquipment> {
        let capacity = Capacity::of_air_loop(model, &ducts::name_of_air_loop(&self.object.name))?;
        Ok(SystemEquipment::of_one(&self.object.name, capacity.with_flow(self.unit.flow.high)))
    }
}

impl FromModel for RoomUnit {
    const NAME: KindName = KindName { id: "room_unit", name: "room unit", plural: "room units" };

    fn claims(_: &Model, candidate: Candidate<'_>) -> Result<bool> {
        Ok(candidate.is_equipment(&UNITS))
    }

    fn make_controllable(model: &mut Model, candidate: Candidate<'_>, air_density: f64) -> Result<Self> {
        let (zone, object) = candidate.equipment()?;
        let air_loop = ducts::put_on_air_loop(model, zone, object)?;
        let unit = unitary::make_controllable(model, &air_loop, air_density)?;
        match air_changes(model, zone, unit.flow.high / air_density)? {
            changes if changes > MOST_AIR_CHANGES => Err(candidate.unsupported(&format!(
                "its design flow changes the air of its room {changes:.0} times an hour; one command per step can hold \
                 at most {MOST_AIR_CHANGES}"
            ))),
            _ => Ok(Self { object: object.clone(), unit }),
        }
    }
}

/// Returns the air changes per hour of a zone by a flow, m³/s; 0 for a zone without a volume.
fn air_changes(model: &Model, zone: &str, flow: f64) -> Result<f64> {
    let zones = zone::zones(model)?;
    let Some(number) = zones.iter().position(|other| other.name.eq_ignore_ascii_case(zone)) else {
        return Ok(0.0);
    };
    let volume = Shape::of(model)?.volume(number) * zones[number].multiplier;
    Ok(if volume > 0.0 { 3600.0 * flow / volume } else { 0.0 })
}

#[cfg(test)]
mod tests;
