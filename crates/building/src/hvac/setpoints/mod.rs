//! Zones that are controlled through the setpoints of their thermostat. A zone's equipment follows: ideal loads, fan
//! coils, packaged terminal units, variable refrigerant flow, unit ventilators, terminals of an air loop. It keeps its
//! schedules of availability and its ventilation. Radiant systems and others that hold temperatures of their own
//! schedules do not follow: a zone with nothing else is left alone.
//!
//! The zone gets a thermostat of its own with a heating and a cooling setpoint at every hour, regardless of what the
//! model's thermostat has. The engine ends a run whose heating setpoint is above the cooling setpoint, so the cooling
//! setpoint is raised to at least [`LEAST_GAP`] above the heating setpoint: see [`separate`].

mod equipment;
mod switches;

use serde::{Deserialize, Serialize};

use super::actuator::{Actuator, EngineVariable, Quantity};
use super::candidate::Candidate;
use super::capacity::{Capacity, SystemEquipment, air_loop_of};
use super::distribution::served_zones;
use super::sequence::Sequence;
use super::system::{FromModel, KindName, System, ZoneState};
use super::thermostat::{OUT_OF_REACH, own_thermostat};
use crate::morphology::universe::NodeType;
use crate::{Conditioning, Model, Result};
pub(super) use equipment::{has_own_temperatures, passes_regardless};
pub(crate) use switches::{Switch, absent, switches_of_all};

/// Bounds of the heating setpoint, °C.
pub const HEATING: [f64; 2] = [10.0, 30.0];
/// Bounds of the cooling setpoint, °C.
pub const COOLING: [f64; 2] = [15.0, 35.0];
/// Least distance of the cooling setpoint above the heating setpoint, K (ASHRAE Guideline 36, 5.3.2: 0.5 K).
pub const LEAST_GAP: f64 = 0.5;
/// Setpoints before the first action, °C.
const INITIAL: [f64; 2] = [20.0, 24.0];

/// A zone whose equipment follows the setpoints of its thermostat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetpointZone {
    /// The zone.
    pub zone: String,
    /// [`Quantity::HeatingSetpoint`].
    pub heating: Actuator,
    /// [`Quantity::CoolingSetpoint`]; `None` for a zone that nothing cools.
    pub cooling: Option<Actuator>,
}

impl SetpointZone {
    /// Number of the actuator of the heating setpoint.
    pub const HEATING: usize = 0;
    /// Number of the actuator of the cooling setpoint, if it has one.
    pub const COOLING: usize = 1;
}

/// Returns the cooling setpoint in use with a heating setpoint (°C): at least [`LEAST_GAP`] above it.
pub fn separate(heating: f64, cooling: f64) -> f64 {
    cooling.max(heating + LEAST_GAP)
}

/// Returns the setpoints that hold a zone at a target (°C), as close to it as [`LEAST_GAP`] allows.
pub fn around(target: f64) -> [f64; 2] {
    [target - 0.5 * LEAST_GAP, target + 0.5 * LEAST_GAP]
}

impl System for SetpointZone {
    fn name(&self) -> &str {
        &self.zone
    }

    fn zones(&self) -> Vec<&str> {
        vec![&self.zone]
    }

    fn actuators(&self) -> Vec<&Actuator> {
        [Some(&self.heating), self.cooling.as_ref()].into_iter().flatten().collect()
    }

    fn conditioning(&self) -> Conditioning {
        match self.cooling {
            Some(_) => Conditioning::HeatingAndCooling,
            None => Conditioning::Heating,
        }
    }

    fn node_type(&self, _: usize) -> NodeType {
        match self.cooling {
            Some(_) => NodeType::SetpointZone,
            None => NodeType::HeatingOnlyZone,
        }
    }

    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]) {
        let target = zone(0).target;
        if self.cooling.is_none() {
            action[Self::HEATING] = target.clamp(HEATING[0], HEATING[1]);
            return;
        }
        let [heating, cooling] = around(target);
        action[Self::HEATING] = heating.clamp(HEATING[0], HEATING[1]);
        action[Self::COOLING] = cooling.clamp(COOLING[0], COOLING[1]);
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence::Setpoints { heating: &self.heating, cooling: self.cooling.as_ref() }
    }

    /// The equipment of the zone, with the air handler of a loop that serves it alone.
    fn equipment(&self, model: &Model) -> Result<SystemEquipment> {
        let mut capacity = Capacity::of_zone_equipment(model, &self.zone)?;
        if let Some(air_loop) = air_loop_of(model, &self.zone)?
            && served_zones(model, &air_loop)?.len() == 1
        {
            let unit = Capacity::of_air_loop(model, &air_loop)?;
            capacity.heating += unit.heating;
            capacity.cooling += unit.cooling;
        }
        Ok(SystemEquipment::of_one(&self.zone, capacity.with_flow(0.0)))
    }
}

impl FromModel for SetpointZone {
    const NAME: KindName =
        KindName { id: "setpoints", name: "thermostat setpoints", plural: "thermostat setpoints" };

    fn claims(_: &Model, candidate: Candidate<'_>) -> Result<bool> {
        Ok(matches!(candidate, Candidate::Zone(_)))
    }

    fn make_controllable(model: &mut Model, candidate: Candidate<'_>, _: f64) -> Result<Self> {
        let zone = candidate.zone()?;
        let mut equipment = equipment::conditioning(model, zone)?;
        if equipment.is_empty() {
            return Err(candidate.unsupported("it has no equipment that heats or cools it"));
        }
        equipment.retain(|item| !has_own_temperatures(model, item));
        if equipment.is_empty() {
            return Err(candidate.unsupported(
                "its equipment holds temperatures of its own schedules, whatever the thermostat calls for",
            ));
        }
        equipment::refuse_deaf(model, zone, &equipment)?;
        let cools = equipment::cools(model, zone, &equipment)?;
        let schedules =
            own_thermostat(model, zone, INITIAL[0], if cools { INITIAL[1] } else { OUT_OF_REACH })?;
        let actuator = |schedule: String, quantity| actuator(zone, schedule, quantity);
        Ok(Self {
            zone: zone.to_owned(),
            heating: actuator(schedules.heating, Quantity::HeatingSetpoint),
            cooling: cools.then(|| actuator(schedules.cooling, Quantity::CoolingSetpoint)),
        })
    }
}

/// The actuator of a setpoint in a schedule.
fn actuator(zone: &str, schedule: String, quantity: Quantity) -> Actuator {
    let (word, title, bounds) = match quantity {
        Quantity::CoolingSetpoint => ("cooling", "Cooling", COOLING),
        _ => ("heating", "Heating", HEATING),
    };
    let effect = EngineVariable::new(&format!("Zone Thermostat {title} Setpoint Temperature"), zone);
    let heat = EngineVariable::new(&format!("Zone Air System Sensible {title} Rate"), zone);
    let name = format!("{zone} {word} setpoint");
    Actuator { heat: Some(heat), ..Actuator::of_schedule(schedule, name, quantity, bounds, effect) }
}

#[cfg(test)]
mod tests;
