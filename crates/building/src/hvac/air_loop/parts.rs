//! A central air loop and its terminals.

use serde::{Deserialize, Serialize};

use crate::hvac::actuator::Actuator;
use crate::hvac::ventilation::Ventilation;

/// A central air loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirLoop {
    /// Name of the `AirLoopHVAC`.
    pub name: String,
    /// [`Quantity::SupplyAirTemperature`](crate::hvac::Quantity::SupplyAirTemperature), of the air handler.
    pub supply_temperature: Actuator,
    /// [`Quantity::OutdoorAirFlow`](crate::hvac::Quantity::OutdoorAirFlow).
    pub outdoor_air: Actuator,
    /// Design flow of the supply fan, kg/s. It limits the flow of all terminals together.
    pub fan_flow: f64,
    /// Design flow of the exhaust fans in its zones, kg/s. Outdoor air makes up for it, regardless of the command.
    pub exhaust_flow: f64,
    /// Its outdoor air.
    pub ventilation: Ventilation,
    /// The terminals, in model order of their zones.
    pub terminals: Vec<Terminal>,
}

/// The terminal of one zone on a central air loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Terminal {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::DamperOpening`](crate::hvac::Quantity::DamperOpening).
    pub damper: Actuator,
    /// [`Quantity::HeatingSetpoint`](crate::hvac::Quantity::HeatingSetpoint), which the reheat coil holds, or a heater
    /// of the zone; `None` for a zone with neither.
    pub reheat: Option<Actuator>,
    /// Design flow, kg/s.
    pub design_flow: f64,
    /// Opening above which more air brings no more heat, 0 to 1, because a hot-water coil is at its capacity; 1 for
    /// other coils.
    pub heating_opening: f64,
}

impl AirLoop {
    /// Number of the actuator of the supply air temperature of the air handler.
    pub const SUPPLY_TEMPERATURE: usize = 0;
    /// Number of the actuator of the outdoor air flow.
    pub const OUTDOOR_AIR: usize = 1;

    /// Numbers of the actuators of every terminal: damper and reheat setpoint.
    pub fn of_terminals(&self) -> impl Iterator<Item = (usize, Option<usize>)> {
        self.terminals.iter().scan(2, |next, terminal| {
            let damper = *next;
            let reheat = terminal.reheat.as_ref().map(|_| damper + 1);
            *next += 1 + usize::from(reheat.is_some());
            Some((damper, reheat))
        })
    }
}
