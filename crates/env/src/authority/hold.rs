//! The sequence of holds, with the commands of all actuators.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Actuator, Quantity, System};

use super::report::{Condition, Level, is_flow};

/// Supply air temperature while flows are tested, °C.
const NEUTRAL_SUPPLY: f64 = 20.0;
/// Supply air temperature while heating setpoints are tested, °C.
const COOL_SUPPLY: f64 = 12.0;
/// Opening of all dampers at which their total flow stays within the fan's design flow.
const OPEN_TOGETHER: f64 = 0.8;

impl Level {
    /// Levels of a flow: up, down, and to zero and back.
    const FLOWS: [Self; 7] =
        [Self::Low, Self::Middle, Self::High, Self::Middle, Self::Low, Self::Zero, Self::Low];
    /// Levels of other quantities: up and down.
    const OTHERS: [Self; 5] = [Self::Low, Self::Middle, Self::High, Self::Middle, Self::Low];

    /// Returns the command of an actuator at this level.
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

/// Commands of all actuators, and the actuators to be evaluated.
pub(super) struct Hold {
    pub(super) action: Vec<f64>,
    pub(super) condition: Condition,
    pub(super) tested: Vec<(usize, Level)>,
}

impl Hold {
    /// `command` returns a value or a level for each actuator; those with a level are evaluated.
    fn new(
        building: &PreparedBuilding,
        condition: Condition,
        command: impl Fn(usize, &Actuator) -> Command,
    ) -> Self {
        let mut tested = Vec::new();
        let action = building.actuators().enumerate().map(|(i, actuator)| match command(i, actuator) {
            Command::Fixed(value) => value,
            Command::Tested(level) => {
                tested.push((i, level));
                level.of(actuator)
            }
        });
        Self { action: action.collect(), condition, tested }
    }
}

/// Command of an actuator in a hold.
enum Command {
    /// A fixed value, not evaluated.
    Fixed(f64),
    /// A level whose response is evaluated.
    Tested(Level),
}

/// Returns the holds whose commands the equipment must follow, in order.
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

/// Flows at their levels, staggered over the dampers of a loop so that their total stays within the fan's flow.
fn flow_hold(building: &PreparedBuilding, turn: usize) -> Hold {
    Hold::new(building, Condition::NeutralSupply, |i, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Command::Tested(Level::FLOWS[turn]),
        Quantity::DamperOpening => Command::Tested(Level::FLOWS[(turn + i / 2) % Level::FLOWS.len()]),
        Quantity::OutdoorAirFlow => Command::Fixed(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Command::Fixed(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Command::Fixed(actuator.low),
    })
}

fn temperature_hold(building: &PreparedBuilding, condition: Condition, share: f64, level: Level) -> Hold {
    Hold::new(building, condition, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Command::Fixed(share * actuator.high),
        Quantity::DamperOpening => Command::Fixed(share * OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Command::Fixed(0.2 * share * actuator.high),
        Quantity::SupplyAirTemperature => Command::Tested(level),
        Quantity::HeatingSetpoint => Command::Fixed(actuator.low),
    })
}

fn outdoor_air_hold(building: &PreparedBuilding, level: Level) -> Hold {
    Hold::new(building, Condition::NeutralSupply, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Command::Fixed(0.5 * actuator.high),
        Quantity::DamperOpening => Command::Fixed(OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Command::Tested(level),
        Quantity::SupplyAirTemperature => Command::Fixed(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Command::Fixed(actuator.low),
    })
}

fn all_open_hold(building: &PreparedBuilding) -> Hold {
    Hold::new(building, Condition::AllOpen, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Command::Fixed(0.5 * actuator.high),
        Quantity::DamperOpening => Command::Tested(Level::High),
        Quantity::OutdoorAirFlow => Command::Fixed(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Command::Fixed(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Command::Fixed(actuator.low),
    })
}

pub(super) fn heat_hold(building: &PreparedBuilding, level: Level) -> Hold {
    Hold::new(building, Condition::CoolSupply, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Command::Fixed(0.3 * actuator.high),
        Quantity::DamperOpening => Command::Fixed(OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Command::Fixed(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Command::Fixed(COOL_SUPPLY),
        Quantity::HeatingSetpoint => Command::Tested(level),
    })
}
