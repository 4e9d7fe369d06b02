//! The small fixed controller that runs in warm-up.
//!
//! It is part of the environment's definition: every episode starts near its target, the same for every agent.
//! With idle systems zones drift to 30 °C and the engine's warm-up does not converge.

use b2b_building::hvac::{AirLoop, System};

/// Temperature deviation at which a proportional command is full, K. With half of it kitchens, whose supply is
/// a large share of their air, swing for ever in the cold and warm-up does not converge.
const UNITARY_BAND: f64 = 4.0;
/// The same for the dampers of a central air loop, K.
const DAMPER_BAND: f64 = 2.0;
/// Smallest share of a unitary system's design flow.
const LEAST_FLOW: f64 = 0.3;
/// Supply air over and under target at full command, K.
const HEATING_LIFT: f64 = 20.0;
const COOLING_DROP: f64 = 8.0;
/// Supply temperature of a central air loop, °C.
const CENTRAL_SUPPLY: f64 = 14.0;
/// Smallest opening of a damper, and outdoor air as a share of the fan's design flow.
const LEAST_OPENING: f64 = 0.2;
const OUTDOOR_SHARE: f64 = 0.2;

/// Writes the action of the warm-up controller.
/// `zone` gives a zone's target and air temperature, °C.
pub(crate) fn action(systems: &[System], zone: impl Fn(&str) -> [f64; 2], action: &mut [f64]) {
    let mut rest = action;
    for system in systems {
        match system {
            System::Unitary(unit) => {
                let [target, temperature] = zone(&unit.zone);
                let demand = ((target - temperature) / UNITARY_BAND).clamp(-1.0, 1.0);
                rest[0] = unit.flow.high * (LEAST_FLOW + (1.0 - LEAST_FLOW) * demand.abs());
                rest[1] = target + demand * if demand > 0.0 { HEATING_LIFT } else { COOLING_DROP };
                rest = &mut rest[2..];
            }
            System::AirLoop(air_loop) => {
                central(air_loop, &zone, rest);
                rest = &mut rest[2 + 2 * air_loop.terminals.len()..];
            }
            System::HeatingOnly(heater) => {
                rest[0] = zone(&heater.zone)[0];
                rest = &mut rest[1..];
            }
        }
    }
}

fn central(air_loop: &AirLoop, zone: &impl Fn(&str) -> [f64; 2], action: &mut [f64]) {
    action[0] = CENTRAL_SUPPLY;
    action[1] = OUTDOOR_SHARE * air_loop.fan_flow;
    for (terminal, action) in air_loop.terminals.iter().zip(action[2..].chunks_exact_mut(2)) {
        let [target, temperature] = zone(&terminal.zone);
        let too_warm = (temperature - target) / DAMPER_BAND;
        action[0] = (LEAST_OPENING + too_warm).clamp(LEAST_OPENING, 1.0);
        action[1] = target;
    }
}
