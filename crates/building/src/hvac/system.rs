//! The controllable systems of a building.

use serde::{Deserialize, Serialize};

use super::actuator::Actuator;
use super::ventilation::Ventilation;

/// A group of actuators that act together on their zones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum System {
    /// One unit, one zone: flow and supply temperature.
    Unitary(Unitary),
    /// One air handler, many zones.
    AirLoop(AirLoop),
    /// A heater under a thermostat.
    HeatingOnly(HeatingOnly),
}

impl System {
    /// Its outdoor air, if it has any.
    pub fn ventilation(&self) -> Option<&Ventilation> {
        match self {
            System::Unitary(unit) => unit.ventilation.as_ref(),
            System::AirLoop(air_loop) => Some(&air_loop.ventilation),
            System::HeatingOnly(_) => None,
        }
    }

    /// The zones it serves.
    pub fn zones(&self) -> Vec<&str> {
        match self {
            System::Unitary(unit) => vec![&unit.zone],
            System::AirLoop(air_loop) => air_loop.terminals.iter().map(|t| t.zone.as_str()).collect(),
            System::HeatingOnly(heater) => vec![&heater.zone],
        }
    }
}

/// A unitary system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unitary {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::SupplyAirFlow`](super::Quantity::SupplyAirFlow).
    pub flow: Actuator,
    /// [`Quantity::SupplyAirTemperature`](super::Quantity::SupplyAirTemperature).
    pub supply_temperature: Actuator,
    /// Its outdoor air; `None` for a unit without any.
    pub ventilation: Option<Ventilation>,
}

/// A central air loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirLoop {
    /// Name of the `AirLoopHVAC`.
    pub name: String,
    /// [`Quantity::SupplyAirTemperature`](super::Quantity::SupplyAirTemperature), of the air handler.
    pub supply_temperature: Actuator,
    /// [`Quantity::OutdoorAirFlow`](super::Quantity::OutdoorAirFlow).
    pub outdoor_air: Actuator,
    /// Design flow of the supply fan, kg/s. It limits the flow of all terminals together.
    pub fan_flow: f64,
    /// Design flow of the exhaust fans in its zones, kg/s. Outdoor air makes up for it, whatever is commanded.
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
    /// [`Quantity::DamperOpening`](super::Quantity::DamperOpening).
    pub damper: Actuator,
    /// [`Quantity::HeatingSetpoint`](super::Quantity::HeatingSetpoint), of the reheat coil.
    pub reheat: Actuator,
    /// Design flow, kg/s.
    pub design_flow: f64,
    /// Opening above which more air brings no more heat, 0 to 1, because a hot-water coil is at its capacity; 1 for other
    /// coils.
    pub heating_opening: f64,
}

/// A zone heater without cooling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatingOnly {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::HeatingSetpoint`](super::Quantity::HeatingSetpoint).
    pub setpoint: Actuator,
}
