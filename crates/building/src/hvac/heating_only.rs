//! Zones with a heater and no cooling, controlled by the heating setpoint of their thermostat.

use serde::{Deserialize, Serialize};

use super::actuator::{Actuator, EngineVariable, Quantity};
use super::availability::switch_on;
use super::candidate::Candidate;
use super::references::{Reference, parts};
use super::sequence::Sequence;
use super::system::{FromModel, KindName, System, ZoneState};
use super::thermostat::{OUT_OF_REACH, own_thermostat};
use super::zone_equipment::HEATERS;
use crate::model::{Model, number, text};
use crate::morphology::NodeType;
use crate::{Conditioning, Error, Result};

/// Bounds of the heating setpoint, °C. The lower bound means "off": no heated zone gets so cold.
pub const SETPOINT: (f64, f64) = (5.0, 35.0);

/// A zone heater without cooling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatingOnly {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::HeatingSetpoint`].
    pub setpoint: Actuator,
}

impl HeatingOnly {
    /// Number of the actuator of the heating setpoint.
    pub const SETPOINT: usize = 0;
}

impl System for HeatingOnly {
    fn name(&self) -> &str {
        &self.zone
    }

    fn zones(&self) -> Vec<&str> {
        vec![&self.zone]
    }

    fn actuators(&self) -> Vec<&Actuator> {
        vec![&self.setpoint]
    }

    fn conditioning(&self) -> Conditioning {
        Conditioning::Heating
    }

    fn node_type(&self, _: usize) -> NodeType {
        NodeType::HeatingOnlyZone
    }

    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]) {
        action[Self::SETPOINT] = zone(0).target;
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence::Thermostat
    }
}

impl FromModel for HeatingOnly {
    const NAME: KindName = KindName { id: "heating_only", name: "heater", plural: "heaters" };

    fn claims(_: &Model, candidate: Candidate<'_>) -> Result<bool> {
        Ok(candidate.is_equipment(&HEATERS))
    }

    fn make_controllable(model: &mut Model, candidate: Candidate<'_>, _: f64) -> Result<Self> {
        let (zone, heater) = candidate.equipment()?;
        make_controllable(model, zone, heater)
    }
}

/// Makes the heater of a zone controllable: always available, under a thermostat of the zone's own.
///
/// # Errors
/// [`crate::Error::Unsupported`] when the zone has no thermostat or the heater no capacity;
/// [`crate::Error::MissingObject`] when the heater's parts are not in the model.
pub fn make_controllable(model: &mut Model, zone: &str, heater: &Reference) -> Result<HeatingOnly> {
    refuse_powerless(model, heater)?;
    switch_on(model, heater)?;
    let setpoints = own_thermostat(model, zone, SETPOINT.0, OUT_OF_REACH)?;
    let heat = heat(model, heater)?;
    let effect = EngineVariable::new("Zone Thermostat Heating Setpoint Temperature", zone);
    let label = format!("{zone} heating setpoint");
    let bounds = [SETPOINT.0, SETPOINT.1];
    let setpoint = Actuator::of_schedule(setpoints.heating, label, Quantity::HeatingSetpoint, bounds, effect);
    Ok(HeatingOnly { zone: zone.to_owned(), setpoint: Actuator { heat: Some(heat), ..setpoint } })
}

/// Rejects a heater of zero capacity, as sized for a zone that needs no heat: its setpoint would have no effect.
pub(super) fn refuse_powerless(model: &Model, heater: &Reference) -> Result<()> {
    let parts = parts(model.require(&heater.class, &heater.name)?);
    let has_none = |part: &Reference| {
        let capacity = model.get(&part.class, &part.name).and_then(|f| number(f, "nominal_capacity"));
        capacity.is_some_and(|capacity| capacity <= 0.0)
    };
    match parts.iter().any(has_none) {
        true => {
            let why = "its capacity is zero: the zone needs no heat on the design days";
            Err(Error::unsupported(&heater.class, &heater.name, why))
        }
        false => Ok(()),
    }
}

/// Returns the engine variable of a heater's heating rate: its coil's, or its own if it has no coil.
pub(super) fn heat(model: &Model, heater: &Reference) -> Result<EngineVariable> {
    let coil = text(model.require(&heater.class, &heater.name)?, "heating_coil_name");
    Ok(match coil {
        Some(coil) => EngineVariable::new("Heating Coil Heating Rate", coil),
        None => EngineVariable::new("Baseboard Total Heating Rate", &heater.name),
    })
}
