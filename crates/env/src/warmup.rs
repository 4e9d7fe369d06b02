//! The fixed controller of the warm-up period.
//!
//! It is part of the definition of an environment: every episode starts near its target, the same for every agent.
//! With idle systems, zones drift to 30 °C and the warm-up of EnergyPlus does not converge.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{AirLoop, HeatingOnly, System, SystemLayout, Unitary};

use crate::reward::ZoneStep;

/// Temperature deviation at full command of a unitary system, K. At half of this, kitchens, whose supply is a large
/// share of their air, oscillate in cold climates, and warm-up does not converge.
const UNITARY_BAND: f64 = 4.0;
/// Temperature deviation at full damper opening, K.
const DAMPER_BAND: f64 = 2.0;
/// Minimum flow of a unitary system, as a fraction of its design flow.
const MIN_FLOW: f64 = 0.3;
/// Supply air temperature above target at full heating, K.
const HEATING_LIFT: f64 = 20.0;
/// Supply air temperature below target at full cooling, K.
const COOLING_DROP: f64 = 8.0;
/// Supply air temperature of a central air loop, °C.
const CENTRAL_SUPPLY: f64 = 14.0;
/// Minimum damper opening.
const MIN_OPENING: f64 = 0.2;
/// Outdoor air of a central air loop, as a fraction of the fan's design flow.
const OUTDOOR_SHARE: f64 = 0.2;

/// Writes the action of the warm-up controller, given the controlled zones in model order.
pub(crate) fn act(building: &PreparedBuilding, zones: &[ZoneStep], action: &mut [f64]) {
    for (system, layout) in building.laid_out_systems() {
        let action = &mut action[layout.actions.clone()];
        match system {
            System::Unitary(unit) => unitary(unit, &zones[layout.zones[0].controlled], action),
            System::AirLoop(air_loop) => central(air_loop, layout, zones, action),
            System::HeatingOnly(_) => {
                action[HeatingOnly::SETPOINT] = zones[layout.zones[0].controlled].target;
            }
        }
    }
}

fn unitary(unit: &Unitary, zone: &ZoneStep, action: &mut [f64]) {
    let demand = ((zone.target - zone.temperature) / UNITARY_BAND).clamp(-1.0, 1.0);
    action[Unitary::FLOW] = unit.flow.high * (MIN_FLOW + (1.0 - MIN_FLOW) * demand.abs());
    action[Unitary::SUPPLY_TEMPERATURE] =
        zone.target + demand * if demand > 0.0 { HEATING_LIFT } else { COOLING_DROP };
}

fn central(air_loop: &AirLoop, layout: &SystemLayout, zones: &[ZoneStep], action: &mut [f64]) {
    action[AirLoop::SUPPLY_TEMPERATURE] = CENTRAL_SUPPLY;
    action[AirLoop::OUTDOOR_AIR] = OUTDOOR_SHARE * air_loop.fan_flow;
    for (terminal, served) in layout.zones.iter().enumerate() {
        let zone = &zones[served.controlled];
        let cooling = (zone.temperature - zone.target) / DAMPER_BAND;
        action[AirLoop::damper(terminal)] = (MIN_OPENING + cooling).clamp(MIN_OPENING, 1.0);
        action[AirLoop::reheat(terminal)] = zone.target;
    }
}
