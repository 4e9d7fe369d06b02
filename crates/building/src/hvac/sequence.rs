//! Sequences of operation: how rule-based controllers control a system.

use super::actuator::Actuator;
use super::air_loop::parts::AirLoop;
use super::unitary::packaged::Packaged;

/// The sequence of operation that applies to a system. It depends on the actuators rather than on the equipment behind
/// them, so that several kinds may have the same.
#[derive(Clone, Copy, Debug)]
pub enum Sequence<'a> {
    /// A zone with supply air, which others may share: actuator 0 is the supply air flow, actuator 1 the supply air
    /// temperature.
    SingleZone {
        /// [`Quantity::SupplyAirFlow`](super::Quantity::SupplyAirFlow).
        flow: &'a Actuator,
        /// [`Quantity::SupplyAirTemperature`](super::Quantity::SupplyAirTemperature).
        supply_temperature: &'a Actuator,
        /// The unit.
        packaged: Packaged,
    },
    /// Zones with dampers, some with reheat, on one air handler.
    MultipleZones(&'a AirLoop),
    /// A zone under a thermostat: actuator 0 is its heating setpoint.
    Thermostat,
    /// A zone whose equipment follows the setpoints of its thermostat.
    Setpoints {
        /// Actuator 0, [`Quantity::HeatingSetpoint`](super::Quantity::HeatingSetpoint).
        heating: &'a Actuator,
        /// Actuator 1, [`Quantity::CoolingSetpoint`](super::Quantity::CoolingSetpoint); `None` for a zone that nothing
        /// cools.
        cooling: Option<&'a Actuator>,
    },
}
