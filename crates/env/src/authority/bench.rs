//! The response check of a building in one season.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Actuator, AirLoop, Quantity, System};

use super::heat::{heated_zones, judge_heat};
use super::hold::{Hold, heat_hold};
use super::reading::Reading;
use super::report::{Level, Limit, Row, Season};
use crate::Result;
use crate::env::Env;

/// Steps of a hold; the first lets the system settle.
const HOLD_STEPS: usize = 9;
/// Steps that probing a miss at the end of a hold may add.
const PROBE_STEPS: usize = 2;
/// Steps of a heating setpoint hold.
const HEAT_STEPS: usize = 24;

/// A building under test in one season.
pub(super) struct Bench<'a> {
    pub(super) env: Env,
    pub(super) building: &'a PreparedBuilding,
    pub(super) season: Season,
    pub(super) readings: Vec<Reading>,
}

impl Bench<'_> {
    pub(super) fn hold(&mut self, hold: &Hold) -> Result<()> {
        let actuators: Vec<_> = self.building.actuators().collect();
        let tested =
            |(i, level): &(usize, Level)| Reading::new(actuators[*i], self.season, hold.condition, *level);
        let mut readings: Vec<_> = hold.tested.iter().map(tested).collect();
        let mut action = hold.action.clone();
        for step in 0..HOLD_STEPS + PROBE_STEPS {
            if step >= HOLD_STEPS && readings.iter().all(Reading::is_settled) {
                break;
            }
            for ((i, _), reading) in hold.tested.iter().zip(&readings) {
                action[*i] = reading.nearer.unwrap_or(reading.row.command);
            }
            self.env.step(&action)?;
            for ((i, _), reading) in hold.tested.iter().zip(&mut readings) {
                if (1..HOLD_STEPS).contains(&step) || !reading.is_settled() {
                    reading.see(actuators[*i], self.effect(*i, actuators[*i]));
                }
            }
        }
        for ((i, _), reading) in hold.tested.iter().zip(&mut readings) {
            reading.limit = reading.coil_limit().or(self.flow_limit(*i, &reading.row));
        }
        self.readings.append(&mut readings);
        Ok(())
    }

    /// Returns the controlled quantity of an actuator, in the unit of its command.
    fn effect(&self, i: usize, actuator: &Actuator) -> f64 {
        self.env.effect(i).unwrap_or(f64::NAN) / actuator.effect_scale
    }

    /// Returns the limit that the air loop of an actuator has reached, if any.
    fn flow_limit(&self, i: usize, row: &Row) -> Option<Limit> {
        let (system, layout) =
            self.building.laid_out_systems().find(|(_, layout)| layout.actions.contains(&i))?;
        let System::AirLoop(air_loop) = system else { return None };
        let effect = |offset: usize| self.env.effect(layout.actions.start + offset).unwrap_or(f64::NAN);
        let supplied: f64 = (0..layout.zones.len()).map(|terminal| effect(AirLoop::damper(terminal))).sum();
        let reaches = |flow: f64, limit: f64, tolerance: f64| (flow / limit - 1.0).abs() <= tolerance;
        match row.quantity {
            Quantity::DamperOpening => reaches(supplied, air_loop.fan_flow, 0.01).then_some(Limit::Fan),
            Quantity::OutdoorAirFlow => {
                let outdoor = effect(AirLoop::OUTDOOR_AIR);
                let makes_up = outdoor > row.command && outdoor <= 1.02 * air_loop.exhaust_flow;
                let all = reaches(outdoor, supplied, 0.02).then_some(Limit::SupplyFlow);
                all.or(makes_up.then_some(Limit::Exhaust))
            }
            _ => None,
        }
    }

    /// Raises and lowers the heating setpoints, and evaluates heat and zone temperature.
    pub(super) fn heat(&mut self) -> Result<Vec<Row>> {
        const LEVELS: [Level; 5] = [Level::Low, Level::Middle, Level::Low, Level::High, Level::Low];
        let zones = heated_zones(self.building);
        let actuators: Vec<_> = self.building.actuators().collect();
        let mut rows: Vec<Vec<Row>> = Vec::new();
        for level in LEVELS {
            let hold = heat_hold(self.building, level);
            let read =
                |&(i, _): &(usize, usize)| Reading::new(actuators[i], self.season, hold.condition, level);
            let mut readings: Vec<_> = zones.iter().map(read).collect();
            for _ in 0..HEAT_STEPS {
                let step = self.env.step(&hold.action)?;
                for (&(i, slot), reading) in zones.iter().zip(&mut readings) {
                    reading.add(actuators[i], step.observation[slot]);
                }
            }
            let ended = |(&(i, _), reading): (&(usize, usize), Reading)| {
                let heat = self.env.heat(i);
                Row {
                    mean: reading.last,
                    heat,
                    error: (reading.last - reading.row.command).abs(),
                    ..reading.row
                }
            };
            rows.push(zones.iter().zip(readings).map(ended).collect());
        }
        Ok((0..zones.len())
            .flat_map(|zone| judge_heat([0, 1, 2, 3, 4].map(|hold| &rows[hold][zone])))
            .collect())
    }
}
