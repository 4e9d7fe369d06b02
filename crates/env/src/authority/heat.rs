//! Response to heating setpoints: heat delivered and zone temperature.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Actuator, Quantity};
use b2b_building::morphology::Owner;

use super::hold::setpoints;
use super::report::{Limit, Row, Verdict};

/// Tolerance within which a zone is at its setpoint, K.
pub(super) const AT_SETPOINT: f64 = 0.5;
/// Smallest significant change of the zone temperature, K.
pub(super) const RISE: f64 = 0.05;
/// Smallest significant heat, W.
pub(super) const SOME_HEAT: f64 = 1.0;

/// Returns the indices of the heating setpoints of terminals and heaters, each with the slot of its zone temperature.
pub(super) fn heated_zones(building: &PreparedBuilding) -> Vec<(usize, usize)> {
    let thermostats = setpoints(building);
    let heated = |(index, (owner, actuator)): (usize, (Owner, &Actuator))| match owner {
        Owner::Zone(_) if thermostats.contains(&index) => None,
        Owner::Zone(zone) if actuator.quantity == Quantity::HeatingSetpoint => Some((index, zone)),
        _ => None,
    };
    building.owned_actuators().enumerate().filter_map(heated).collect()
}

/// Evaluates the holds low, middle, low, high, low. Every raise is compared with the holds before and after.
pub(super) fn judge_heat(holds: [&Row; 5]) -> [Row; 3] {
    let [before, middle, between, high, after] = holds;
    let raised = |row: &Row, low: [&Row; 2]| Row { verdict: judge_raise(row, low), ..row.clone() };
    let low = Row { verdict: judge_idle(before), ..before.clone() };
    [low, raised(middle, [before, between]), raised(high, [between, after])]
}

/// A raised setpoint must increase heat and temperature, unless the zone is above it and gets no heat. In a zone that
/// never comes near its setpoint, the heater is at capacity.
fn judge_raise(row: &Row, low: [&Row; 2]) -> Verdict {
    let base = |value: fn(&Row) -> f64| 0.5 * (value(low[0]) + value(low[1]));
    let heat = |row: &Row| row.heat.unwrap_or(0.0);
    let rises = row.mean > base(|row| row.mean) + RISE;
    let holds = (row.mean - row.command).abs() <= AT_SETPOINT;
    if heat(row) > base(heat) + SOME_HEAT && (rises || holds) {
        heated(row)
    } else if heat(row) < SOME_HEAT && row.mean > row.command {
        Verdict::AtCapacity(Limit::WarmZone)
    } else {
        Verdict::Fails
    }
}

/// A zone must get heat below its setpoint and none above.
fn judge_idle(row: &Row) -> Verdict {
    let gets_heat = row.heat.unwrap_or(0.0) > SOME_HEAT;
    match row.mean - row.command {
        above if above > AT_SETPOINT && gets_heat => Verdict::Fails,
        above if above < -AT_SETPOINT && !gets_heat => Verdict::Fails,
        _ => heated(row),
    }
}

/// The verdict on a zone that responds correctly.
fn heated(row: &Row) -> Verdict {
    if row.highest < row.command - AT_SETPOINT {
        return Verdict::AtCapacity(Limit::Heater);
    }
    Verdict::Follows
}
