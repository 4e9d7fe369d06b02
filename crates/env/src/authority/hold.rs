//! The sequence of holds, with the commands of all actuators.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Actuator, Quantity, Sequence, System, SystemLayout};

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

/// Commands of the actuators that are not tested.
#[derive(Clone, Copy)]
struct Rest {
    /// Supply air flow, as a fraction of its upper bound.
    flow: f64,
    /// Opening of the dampers.
    opening: f64,
    /// Outdoor air flow, as a fraction of its upper bound.
    outdoor_air: f64,
    /// Supply air temperature, °C.
    supply: f64,
}

impl Rest {
    /// Dampers open together, as far as the fan can supply them all.
    const OPEN: Self = Self { flow: 0.5, opening: OPEN_TOGETHER, outdoor_air: 0.1, supply: NEUTRAL_SUPPLY };

    fn command(&self, actuator: &Actuator) -> f64 {
        match actuator.quantity {
            Quantity::SupplyAirFlow => self.flow * actuator.high,
            Quantity::DamperOpening => self.opening,
            Quantity::OutdoorAirFlow => self.outdoor_air * actuator.high,
            Quantity::SupplyAirTemperature => self.supply,
            Quantity::HeatingSetpoint => actuator.low,
            Quantity::CoolingSetpoint => actuator.high,
        }
    }
}

impl Hold {
    /// Creates a hold that evaluates the actuators for which `tested` returns a level.
    fn new(
        building: &PreparedBuilding,
        condition: Condition,
        rest: Rest,
        tested: impl Fn(usize, Quantity) -> Option<Level>,
    ) -> Self {
        let actuators = || building.actuators().enumerate();
        let level = |(i, actuator): (usize, &Actuator)| Some((i, tested(i, actuator.quantity)?));
        let command = |(i, actuator): (usize, &Actuator)| match tested(i, actuator.quantity) {
            Some(level) => level.of(actuator),
            None => rest.command(actuator),
        };
        let action = actuators().map(command).collect();
        Self { action, condition, tested: actuators().filter_map(level).collect() }
    }
}

/// Returns the holds whose commands the equipment must follow, in order.
pub(super) fn follow_holds(building: &PreparedBuilding) -> Vec<Hold> {
    let mut holds: Vec<_> = (0..Level::FLOWS.len()).map(|turn| flow_hold(building, turn)).collect();
    for (condition, share) in [(Condition::MiddleFlow, 0.5), (Condition::FullFlow, 1.0)] {
        holds.extend(Level::OTHERS.map(|level| temperature_hold(building, condition, share, level)));
    }
    if building.actuators().any(|actuator| actuator.quantity == Quantity::OutdoorAirFlow) {
        holds.extend(Level::FLOWS.map(|level| outdoor_air_hold(building, level)));
        holds.push(all_open_hold(building));
    }
    holds
}

/// Flows at their levels, staggered over the dampers of a loop so that their total stays within the fan's flow.
fn flow_hold(building: &PreparedBuilding, turn: usize) -> Hold {
    Hold::new(building, Condition::NeutralSupply, Rest::OPEN, |i, quantity| match quantity {
        Quantity::SupplyAirFlow => Some(Level::FLOWS[turn]),
        Quantity::DamperOpening => Some(Level::FLOWS[(turn + i / 2) % Level::FLOWS.len()]),
        _ => None,
    })
}

/// Supply temperatures at a share of the flows.
fn temperature_hold(building: &PreparedBuilding, condition: Condition, share: f64, level: Level) -> Hold {
    let opening = share * OPEN_TOGETHER;
    let rest = Rest { flow: share, opening, outdoor_air: 0.2 * share, ..Rest::OPEN };
    Hold::new(building, condition, rest, |_, quantity| {
        (quantity == Quantity::SupplyAirTemperature).then_some(level)
    })
}

fn outdoor_air_hold(building: &PreparedBuilding, level: Level) -> Hold {
    Hold::new(building, Condition::NeutralSupply, Rest::OPEN, |_, quantity| {
        (quantity == Quantity::OutdoorAirFlow).then_some(level)
    })
}

fn all_open_hold(building: &PreparedBuilding) -> Hold {
    Hold::new(building, Condition::AllOpen, Rest::OPEN, |_, quantity| {
        (quantity == Quantity::DamperOpening).then_some(Level::High)
    })
}

pub(super) fn heat_hold(building: &PreparedBuilding, level: Level) -> Hold {
    let rest = Rest { flow: 0.3, supply: COOL_SUPPLY, ..Rest::OPEN };
    let thermostats = setpoints(building);
    Hold::new(building, Condition::CoolSupply, rest, |i, quantity| {
        (quantity == Quantity::HeatingSetpoint && !thermostats.contains(&i)).then_some(level)
    })
}

/// A hold in which the setpoints of one quantity are at a level, and the others do not call for anything.
pub(super) fn setpoint_hold(building: &PreparedBuilding, tested: Option<(Quantity, Level)>) -> Hold {
    let thermostats = setpoints(building);
    Hold::new(building, Condition::Free, Rest::OPEN, |i, quantity| {
        let level = tested.filter(|(tested, _)| *tested == quantity).map(|(_, level)| level);
        level.filter(|_| thermostats.contains(&i))
    })
}

/// Returns whether all actuators of a building are setpoints of thermostats.
pub(super) fn drives_all(building: &PreparedBuilding) -> bool {
    setpoints(building).len() == building.actuators().count()
}

/// Returns the indices of the setpoints of zones that are controlled through their thermostats.
pub(super) fn setpoints(building: &PreparedBuilding) -> Vec<usize> {
    let of = |(system, layout): (&dyn System, &SystemLayout)| match system.sequence() {
        Sequence::Setpoints { .. } => layout.actions.clone(),
        _ => 0..0,
    };
    building.laid_out_systems().flat_map(of).collect()
}
