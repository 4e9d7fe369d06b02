//! Zones with a heater and no cooling, controlled by the heating setpoint of their thermostat.

use super::actuator::{Actuator, EngineVariable, Quantity};
use super::availability::switch_on;
use super::references::{Reference, is_one_of, parts};
use super::system::HeatingOnly;
use super::thermostat::{OUT_OF_REACH, own_thermostat};
use crate::model::{Model, number, text};
use crate::{Error, Result};

/// Bounds of the heating setpoint, °C. The lower bound means "off": no heated zone gets so cold.
pub const SETPOINT: (f64, f64) = (5.0, 35.0);

const HEATERS: [&str; 5] = [
    "ZoneHVAC:UnitHeater",
    "ZoneHVAC:Baseboard:Convective:Electric",
    "ZoneHVAC:Baseboard:Convective:Water",
    "ZoneHVAC:Baseboard:RadiantConvective:Electric",
    "ZoneHVAC:Baseboard:RadiantConvective:Water",
];

/// Returns whether an object class is a zone heater that follows a thermostat.
pub(super) fn is_heater(class: &str) -> bool {
    is_one_of(class, &HEATERS)
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
fn refuse_powerless(model: &Model, heater: &Reference) -> Result<()> {
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

/// Returns the engine variable of a heater's heating rate: that of its coil, or its own if it has none.
fn heat(model: &Model, heater: &Reference) -> Result<EngineVariable> {
    let coil = text(model.require(&heater.class, &heater.name)?, "heating_coil_name");
    Ok(match coil {
        Some(coil) => EngineVariable::new("Heating Coil Heating Rate", coil),
        None => EngineVariable::new("Baseboard Total Heating Rate", &heater.name),
    })
}
