//! What is asked of all actuators, one hold after the other.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Actuator, Quantity, System};

use super::report::{Condition, Level, is_flow};

/// Supply air while flows are tested, °C; while heating setpoints are tested.
const NEUTRAL_SUPPLY: f64 = 20.0;
const COOL_SUPPLY: f64 = 12.0;
/// Opening of all dampers that stays within the fan's design flow.
const OPEN_TOGETHER: f64 = 0.8;

impl Level {
    /// From bottom to top and back; a flow goes to zero and comes back from it too.
    const FLOWS: [Self; 7] =
        [Self::Low, Self::Middle, Self::High, Self::Middle, Self::Low, Self::Zero, Self::Low];
    const OTHERS: [Self; 5] = [Self::Low, Self::Middle, Self::High, Self::Middle, Self::Low];

    pub(super) fn of(self, actuator: &Actuator) -> f64 {
        let share = match (self, is_flow(actuator.quantity)) {
            (Self::Zero, _) | (Self::Low, false) => 0.0,
            (Self::Low, true) => 0.2,
            (Self::Middle, true) => 0.6,
            (Self::Middle, false) => 0.5,
            (Self::High, _) => 1.0,
        };
        actuator.low + share * (actuator.high - actuator.low)
    }
}

/// Values for every actuator, and which of them are judged.
pub(super) struct Hold {
    pub(super) action: Vec<f64>,
    pub(super) condition: Condition,
    pub(super) judged: Vec<(usize, Level)>,
}

impl Hold {
    /// `give` says for each actuator its value or its level; a level is judged.
    fn new(
        building: &PreparedBuilding,
        condition: Condition,
        give: impl Fn(usize, &Actuator) -> Give,
    ) -> Self {
        let mut judged = Vec::new();
        let action = building.actuators().enumerate().map(|(i, actuator)| match give(i, actuator) {
            Give::Value(value) => value,
            Give::Judged(level) => {
                judged.push((i, level));
                level.of(actuator)
            }
        });
        Self { action: action.collect(), condition, judged }
    }
}

enum Give {
    Value(f64),
    Judged(Level),
}

/// Every hold whose commands are to be followed, in order.
pub(super) fn follow_holds(building: &PreparedBuilding) -> Vec<Hold> {
    let mut holds: Vec<_> = (0..Level::FLOWS.len()).map(|turn| flow_hold(building, turn)).collect();
    for (condition, share) in [(Condition::MiddleFlow, 0.5), (Condition::FullFlow, 1.0)] {
        holds.extend(Level::OTHERS.map(|level| temperature_hold(building, condition, share, level)));
    }
    if building.systems.iter().any(|s| matches!(s, System::AirLoop(_))) {
        holds.extend(Level::FLOWS.map(|level| outdoor_air_hold(building, level)));
        holds.push(all_open_hold(building));
    }
    holds
}

/// Flows at their levels; the dampers of a loop take turns, so that together they stay within the fan's flow.
fn flow_hold(building: &PreparedBuilding, turn: usize) -> Hold {
    Hold::new(building, Condition::NeutralSupply, |i, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Judged(Level::FLOWS[turn]),
        Quantity::DamperOpening => Give::Judged(Level::FLOWS[(turn + i / 2) % Level::FLOWS.len()]),
        Quantity::OutdoorAirFlow => Give::Value(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Give::Value(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

fn temperature_hold(building: &PreparedBuilding, condition: Condition, share: f64, level: Level) -> Hold {
    Hold::new(building, condition, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(share * actuator.high),
        Quantity::DamperOpening => Give::Value(share * OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Give::Value(0.2 * share * actuator.high),
        Quantity::SupplyAirTemperature => Give::Judged(level),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

fn outdoor_air_hold(building: &PreparedBuilding, level: Level) -> Hold {
    Hold::new(building, Condition::NeutralSupply, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(0.5 * actuator.high),
        Quantity::DamperOpening => Give::Value(OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Give::Judged(level),
        Quantity::SupplyAirTemperature => Give::Value(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

fn all_open_hold(building: &PreparedBuilding) -> Hold {
    Hold::new(building, Condition::AllOpen, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(0.5 * actuator.high),
        Quantity::DamperOpening => Give::Judged(Level::High),
        Quantity::OutdoorAirFlow => Give::Value(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Give::Value(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

pub(super) fn heat_hold(building: &PreparedBuilding, level: Level) -> Hold {
    Hold::new(building, Condition::CoolSupply, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(0.3 * actuator.high),
        Quantity::DamperOpening => Give::Value(OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Give::Value(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Give::Value(COOL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Judged(level),
    })
}
